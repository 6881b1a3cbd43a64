"""Contact laws, and the contact models besides the compliant ones."""

from __future__ import annotations

from typing import ClassVar


class ContactKind:
    """Interface of the contact models; the defaults are those of a joint whose clearance is ignored."""

    contacts: ClassVar[bool] = False  # True: contacts replace the rows of the joint
    link: ClassVar[bool] = False  # True: the row of a massless link replaces them, on joints that have one
    oiled: ClassVar[bool] = False  # True: an oil film in the clearance, in parallel with a compliant contact
    assumes: ClassVar[str]  # what the model takes as true and what it leaves out, in plain words for a report
