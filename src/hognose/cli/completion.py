"""`hognose --install-completion`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from hognose.cli.options import OptionalOutput

Shell = Literal["bash", "zsh", "fish"]


def install_completion(*, shell: Shell | None = None, output: OptionalOutput = None) -> int:
    """Let the shell complete commands, options, and the names of tasks and robots.

    Parameters
    ----------
    shell
        The shell; by default, the one that $SHELL names.
    output
        The file to write; by default, where the shell looks for it, in your home folder.
    """
    from hognose.cli.application import app
    from hognose.cli.console import made_folder, say
    from hognose.write_whole import write_whole

    shell = shell or _of_environment()
    file = output or Path.home() / {
        "bash": ".local/share/bash-completion/completions/hognose",
        "zsh": ".zsh/completions/_cyclopts_hognose",
        "fish": ".config/fish/completions/hognose.fish",
    }[shell]  # fmt: skip
    made_folder(file.parent)
    write_whole(file, app.generate_completion(shell=shell).encode())
    say(f"written to {file}: every {shell} that you start from now on reads it")
    if shell == "bash":
        say(f"If it does not, the package bash-completion is missing. Add to ~/.bashrc:\n  source {file}")
    elif shell == "zsh":
        say(f"If it does not, add to ~/.zshrc:\n  fpath=({file.parent} $fpath)\n  autoload -Uz compinit && compinit")
    return 0


def _of_environment() -> Shell:
    from hognose.errors import InputError

    name = Path(os.environ.get("SHELL", "")).name
    if name == "bash" or name == "zsh" or name == "fish":
        return name
    raise InputError(f"--shell: $SHELL names {name or 'no shell'}, expected one of bash, zsh, fish; give --shell")
