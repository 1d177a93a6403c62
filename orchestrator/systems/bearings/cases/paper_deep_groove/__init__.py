"""Deep groove bearing with six degrees of freedom (Sopanen & Mikkola 2003), claim by claim."""
