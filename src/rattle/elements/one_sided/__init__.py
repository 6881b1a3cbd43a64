"""One-sided versions of joints: contacts in place of their rows, without clearance.

The parameters of a kernel are, in this order: the points of A and B (x, y each) [m], then what `parameters` returns.
Where the joint without contact holds two surfaces together on both sides, here they only push.
"""
