"""Contact laws, and the models of contact that stand in `contact` beside the compliant ones."""

from __future__ import annotations

from typing import ClassVar


class ContactKind:
    """What a model of contact says about itself; what is left out is that of a joint whose play is ignored."""

    contacts: ClassVar[bool] = False  # contacts with the clearance act in place of the joint's rows
    link: ClassVar[bool] = False  # the rows of a massless link do, on joints that know one
