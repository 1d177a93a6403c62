"""two_axis_joint"""
