"""`hognose --install-completion`."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from hognose.cli.options import OptionalOutput

if TYPE_CHECKING:
    from cyclopts import App

Shell = Literal["bash", "zsh", "fish"]


def installer_of(app: App) -> Callable[..., int]:
    """The command that lets a shell complete the commands of an application."""

    def install_completion(*, shell: Shell | None = None, output: OptionalOutput = None) -> int:
        """Let the shell complete commands, options, and the names of tasks and robots.

        Parameters
        ----------
        shell
            The shell; by default, the one that $SHELL names.
        output
            The file to write; by default, where the shell looks for it, in your home folder.
        """
        chosen = shell or _of_environment()
        return _install(chosen, app.generate_completion(shell=chosen), output)

    return install_completion


def _install(shell: Shell, script: str, output: Path | None) -> int:
    from hognose.cli.console import made_folder, say
    from hognose.errors import InputError
    from hognose.write_whole import write_whole

    file = output or Path.home() / {
        "bash": ".local/share/bash-completion/completions/hognose",
        "zsh": ".zsh/completions/_cyclopts_hognose",
        "fish": ".config/fish/completions/hognose.fish",
    }[shell]  # fmt: skip
    if output is None:
        made_folder(file.parent)
    elif not file.parent.is_dir():
        raise InputError(f"{file}: cannot write: there is no folder {file.parent}; make it first")
    write_whole(file, script.encode())
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
