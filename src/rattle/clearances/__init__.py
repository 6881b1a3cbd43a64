"""clearances"""
