"""What a user does to a long calculation: Ctrl-C."""


def interrupt_at_call(monkeypatch, owner: type, name: str, number: int) -> list:
    """Let the given call of a method of one argument be interrupted; returns the arguments of the calls so far."""
    method = getattr(owner, name)
    calls = []

    def interrupted(self, argument):
        calls.append(argument)
        if len(calls) == number:
            raise KeyboardInterrupt
        return method(self, argument)

    monkeypatch.setattr(owner, name, interrupted)
    return calls
