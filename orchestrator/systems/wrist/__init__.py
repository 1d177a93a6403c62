"""wrist"""
