"""Text that can't break out of a file's header."""

TEXT_MAX = 200  # a KVN line may have 254 characters


def one_line(text: str) -> str:
    """Printable ASCII on one line, of at most TEXT_MAX characters."""
    printable = "".join(c if " " <= c <= "~" else " " if c.isspace() else "?" for c in text)
    return " ".join(printable.split())[:TEXT_MAX]
