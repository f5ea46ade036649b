# SPDX-License-Identifier: GPL-3.0-or-later
"""A machine "node" for ssh that is this one: a real sshd for each connection, with a key that is made for it."""
import os
import pathlib
import shutil
import signal
import subprocess

SSHD = "/usr/sbin/sshd"


def missing():
    """What of it is not installed; nothing if all is."""
    return [name for name in ("ssh", "ssh-keygen", SSHD) if shutil.which(name) is None]


class LoopbackSsh:
    """``home``: where whoever comes to the node is, in place of their own."""

    def __init__(self, folder, home):
        self._folder = pathlib.Path(folder)
        self._folder.mkdir(mode=0o700)
        if os.geteuid() == 0:
            os.makedirs("/run/sshd", exist_ok=True)  # sshd of root will not begin without it
        for name in ("host", "own"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", self._folder / name], check=True)
        shutil.copy(self._folder / "own.pub", self._folder / "authorized")
        self._write("login", f"#!/bin/sh\nexport HOME={home} LC_MOTE=there\ncd {home} || exit 1\n"
                    'exec /bin/sh -c "$SSH_ORIGINAL_COMMAND"\n', 0o700)
        self._write("sshd_config", f"HostKey {self._folder}/host\nAuthorizedKeysFile {self._folder}/authorized\n"
                    f"PidFile none\nStrictModes no\nUsePAM no\nPermitRootLogin yes\nLogLevel ERROR\n"
                    f"Subsystem sftp /usr/lib/openssh/sftp-server\nForceCommand {self._folder}/login\n")
        known = (self._folder / "host.pub").read_text(encoding="ascii")
        self._write("known", f"node {known}")
        self._write("ssh_config", f"Host node *@node\n  HostName node\n  IdentityFile {self._folder}/own\n"
                    f"  UserKnownHostsFile {self._folder}/known\n  IdentitiesOnly yes\n  BatchMode yes\n  LogLevel ERROR\n"
                    f"  ProxyCommand {SSHD} -i -f {self._folder}/sshd_config\n")

    def _write(self, name, text, mode=0o600):
        with open(os.open(self._folder / name, os.O_WRONLY | os.O_CREAT, mode), "w", encoding="ascii") as file:
            file.write(text)

    def close(self):
        """Ends what still runs of it: tunnels that went to the background."""
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (process / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if str(self._folder / "ssh_config").encode() in words:
                os.kill(int(process.name), signal.SIGTERM)

    def command(self, name="ssh"):
        """ssh or scp, as one string of a shell."""
        return f"{name} -F {self._folder}/ssh_config"
