"""Files of other programs: mechanisms that come in, drawings and tables that go out."""
