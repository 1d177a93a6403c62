"""wind_pump"""
