"""System Structure and Parameterization 1.0 (Modelica Association): systems of FMUs read as scenes, and scenes written."""
