"""rotor"""
