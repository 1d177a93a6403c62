"""System Structure and Parameterization (Modelica Association): systems of FMUs read as scenes, 1.0 and 2.0; scenes written."""
