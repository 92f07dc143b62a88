"""Errors of a policy over the network. After each of them the hand holds."""


class PolicyError(Exception):
    """Failure of a policy server; the message contains cause and advice."""


class PolicyConnectionError(PolicyError):
    """The server cannot be reached, has closed the connection, or reports an error."""


class PolicyChunkError(PolicyError):
    """An answer that is no valid action chunk: format, shape, or a value that is not finite."""


class PolicySilentError(PolicyError):
    """No answer within the time limit."""
