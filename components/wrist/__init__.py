"""Wrist of two carpal rows: its kinematics and dynamics, ligaments, tendons of the forearm, planar four-bar linkages."""
