"""Components as FMI 2.0 co-simulation FMUs: the slave, the builder, the check."""
