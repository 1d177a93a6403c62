"""Rotors: a Jeffcott rotor and a Timoshenko beam rotor with disks, gyroscopic effect and ports for bearings."""
