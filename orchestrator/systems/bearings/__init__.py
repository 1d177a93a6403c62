"""bearings"""
