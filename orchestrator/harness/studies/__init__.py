"""Studies: one scene run many times, in this process, to find out what accuracy costs and where it ends. One study a file."""
