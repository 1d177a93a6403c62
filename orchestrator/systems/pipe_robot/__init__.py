"""pipe_robot"""
