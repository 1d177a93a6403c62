"""friction_drive"""
