"""Text files, written whole or not at all."""

from __future__ import annotations

import os
import secrets

from ifa._core import IfaFileError


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write UTF-8 text beside `path`, then rename it into place; IfaFileError if that fails."""
    name = os.fspath(path)
    temporary = f"{name}.part-{secrets.token_hex(8)}"
    try:
        try:
            with open(temporary, "x", encoding="utf-8") as file:
                file.write(text)
            os.replace(temporary, name)
        finally:
            if os.path.exists(temporary):
                os.unlink(temporary)
    except OSError as error:
        raise IfaFileError(f"{name}: cannot be written: {error.strerror}") from error
