"""Pages of studies: figures first, the table under them. One study a file."""
