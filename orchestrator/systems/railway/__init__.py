"""railway"""
