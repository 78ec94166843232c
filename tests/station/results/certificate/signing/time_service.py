"""A time-stamping service on 127.0.0.1 that answers by RFC 3161: ``openssl ts`` behind an HTTP server."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

from tests.station.results.certificate.signing.authorities import root, stamping_service

SETTINGS = """
[tsa]
default_tsa = one
[one]
serial = {folder}/serial
signer_digest = sha256
default_policy = 1.2.3.4.1
digests = sha256, sha384, sha512
ess_cert_id_chain = no
ess_cert_id_alg = sha256
"""


@contextmanager
def time_service(folder: Path, answer: bytes | None = None) -> Iterator[str]:
    """The address of a service; with ``answer`` one that says that to everybody."""
    folder.mkdir(exist_ok=True)
    settings, owner = folder / "ts.cnf", stamping_service()
    settings.write_text(SETTINGS.format(folder=folder))
    (folder / "serial").write_text("01\n")
    signer, key, chain = owner.pem(folder, "ts"), owner.key_pem(folder, "ts"), root().pem(folder, "root")

    class Service(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            request, reported = folder / "request", folder / "answer"
            request.write_bytes(self.rfile.read(int(self.headers["Content-Length"])))
            if answer is None:
                asked = ["-config", settings, "-queryfile", request, "-signer", signer, "-inkey", key]
                command = ["openssl", "ts", "-reply", *asked, "-chain", chain, "-out", reported]
                subprocess.run(command, check=True, capture_output=True)
            self.send_response(200)
            self.send_header("Content-Type", "application/timestamp-reply")
            self.end_headers()
            self.wfile.write(reported.read_bytes() if answer is None else answer)

        def log_message(self, format: str, *args: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Service) as server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}/tsr"
        finally:
            server.shutdown()
            thread.join()
