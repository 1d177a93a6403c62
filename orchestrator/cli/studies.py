"""Studies: what accuracy costs in time, what stays stable, which effects matter."""
