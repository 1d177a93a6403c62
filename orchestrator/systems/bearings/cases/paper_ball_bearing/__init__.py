"""Ball bearing with two degrees of freedom in dimensionless form (Ambrozkiewicz et al. 2021), claim by claim."""
