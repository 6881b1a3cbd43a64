"""Clearances: the contacts of a joint with clearance, one kind per file.

The parameters of a kernel are, in this order: the points of A and B (x, y each) [m], the clearance [m], the
radius of the bush [m] (0 if it is not needed), the fields of the joint, and its dimensions [m].
"""
