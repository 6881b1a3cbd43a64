"""Names of the columns, rows and places in the arrays `start_` of workspaces: what a start is found from.

`from rattle.equations import start_columns as of`: `m.start_form[of.SMALL]`.
"""

# places in `start_form`: 1 if a mechanism without play is put together first; how many pins are held, and 1 if one of
# them is a massless link; 1 if more can be held; 1 if some of their offsets are given; 1 if pins lie in bushes; 1 if
# there are few rows, and if loops are known; how many unknowns are angles
WITHOUT_PLAY, HELD, LINKS, EVERY, OFFSETS, PINS, SMALL, LOOPED, ANGLES = range(9)

# parts of `start_map`, whose first rows are in `start_parts`
GROUPS, TIED, PASSED, FREE, CAMS, KNOWN, LOOPS, WISH_LOOPS, VECTORS, SLIDES, TERMS, WISHES, PARTS = range(13)
# and their columns
GROUP = 0  # GROUPS: of bodies that turn together, by body
TO, FROM, TIE, SLOT, SIGN = range(5)  # TIED, PASSED: bodies, the joint between them or its driver's place in `values`
# FREE: TO, a body whose angle is sought
WAY, OTHER, OWN_POINT, OTHER_POINT, CAM = range(5)  # CAMS: rollers, cams, points in `values`, the joint
UNKNOWN, KNOWN_AT = range(2)  # KNOWN: slides that drivers determine, places in `values`
FIRST_VECTOR, END_VECTOR, FIRST_SLIDE, END_SLIDE = range(4)  # LOOPS, WISH_LOOPS: rows of VECTORS and SLIDES
# VECTORS: GROUP
SLIDE, TURNS = range(2)  # SLIDES: its number among the unknowns, and the group whose angle it has
INTO, TERM, BODY, PLUS, MINUS, SENSE = range(6)  # TERMS: what is added to a row of VECTORS or SLIDES
POINT, ROD, LINE, GIVEN, DRIVEN, AXIS = range(6)  # TERM.  PLUS, MINUS: points, a joint, a value and its axis
WISH, OF_BODY = range(2)  # WISHES: row of a loop or -1; the body whose angle is given

# columns of `start_ways`: a body, its parent, the joint between them, its first value and its number, what it leaves of
# the place of B's point on A, the number of its slide or rod among the unknowns (-1: none), 1 if no way leads to the
# ground
WAY_BODY, PARENT, WAY_A, WAY_B, WAY_P, WAY_JOINT, FREEDOM, WAY_UNKNOWN, ISLAND = range(9)
FIXED, ALONG_LINE, ABOUT_POINT = range(3)
DIRECTION, DISTANCE, KEPT_ANGLE = range(3)  # columns of `start_lines`

MOVING_POINT, POINT_X, POINT_Y = range(3)  # columns of `start_moving`: a body, places in `values`

PIN, PIN_JOINT = range(2)  # columns of `start_missing`: row of `start_held`, joint

# rows of `start_bodies`: how far a body is ahead of its group, its angle as given or passed on; of groups: where angles
# are looked for, and where they are given
AHEAD, ANGLE, NEAR, EXACT = range(4)
# `start_search`: nodes on the heap, nodes made, looked at; 1 while no value was needed that nobody gave; closings that
# were seen, that count, those after the first; guesses tried; iterations; 1 if numbers have no value; 1 if no later
# guess is better than one that keeps all given values
HEAPED, NODES, LOOKED_AT, COMPLETE, SEEN, CLOSINGS, LATER, TRIED, ITERATIONS, NO_VALUE, SETTLED = range(11)
# columns of `start_nodes` and `start_steps`: numbers of a node, and what made it of which other one
CHANGE, OPEN, AWAY, ONE_VALUE, OTHER_VALUE = range(5)
NODE, EVENT, WHICH, ONE, ANOTHER = range(5)
BEGUN, SET, WITH_LOOP, NO_MORE_WISHES = range(4)  # EVENT
PENDING, ACTIVE, PATH = range(3)  # rows of `start_wishes`
# rows of `start_found`: the guess at hand, where it began, the first closing, that with the nearest angles, where the
# gap is least, further closings, and then those that were seen
NOW, BEFORE, FIRST, BY_ANGLE, LEAST_OPEN, NEXT = range(6)
LOOKED = 6  # closings that are looked at more closely, at most
FIRST_SEEN = NEXT + LOOKED
# `start_judged`: squared changes of given values, how far angles are away, the least gap
OF_FIRST, AWAY_LESS, AWAY_MORE, GAP, OF_LATER = range(5)

# columns of `start_counting`: first row and number of rows of a joint, 1 if its constants are a residual, distance and
# direction of its points and 0; its bodies, and where its points stand in `values`
COUNT_ROW, COUNT_ROWS, POLAR, COUNT_A, COUNT_B, COUNT_P = range(6)
