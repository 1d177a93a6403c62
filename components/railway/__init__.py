"""Pantograph and catenary."""
