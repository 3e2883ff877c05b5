"""What a person gave us and cannot be used: one line, and an exit status."""


class Fault(Exception):
    """status 1: bad input; 2: wrong usage."""

    def __init__(self, message, status=1):
        super().__init__(" ".join(str(message).split()))
        self.status = status
