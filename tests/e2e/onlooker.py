"""Who looks on at a flight (`--view`), by the sockets that a browser has."""

import json
import socket
import threading
from http.client import HTTPConnection
from urllib.parse import urlsplit


class Onlooker:
    """Has the address that a program prints, and so its cookie."""

    def __init__(self, program):
        line = program.lines[program.says("the flight is shown at http://127.0.0.1:") - 1]
        address = urlsplit(line.split()[-1])
        self.host, self.lines = address.netloc, []
        connection = HTTPConnection(self.host)
        connection.request("POST", "/enter", json.dumps({"token": address.fragment}), {"Content-Type": "application/json"})
        answer = connection.getresponse()
        assert answer.status == 204, answer.read()
        self.cookie = answer.headers["Set-Cookie"].split(";")[0]
        connection.close()

    def asks(self):
        """A socket on which the flight was asked for, and which nobody reads."""
        host, port = self.host.split(":")
        asking = socket.socket()
        asking.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
        asking.connect((host, int(port)))
        asking.sendall(f"GET /flight HTTP/1.1\r\nHost: {self.host}\r\nCookie: {self.cookie}\r\n\r\n".encode())
        return asking

    def reads(self):
        """Reads on its own until the flight's end; [`had`](Onlooker.had) has what came."""
        connection = HTTPConnection(self.host)
        connection.request("GET", "/flight", headers={"Cookie": self.cookie})
        answer = connection.getresponse()
        assert answer.status == 200

        def read():
            self.lines.extend(json.loads(line) for line in answer)

        self.reading = threading.Thread(target=read, daemon=True)
        self.reading.start()
        return self

    def had(self):
        """All lines, once the flight is over."""
        self.reading.join(30)
        assert not self.reading.is_alive() and "end" in self.lines[-1], self.lines[-1:]
        return self.lines

    def rows(self):
        """The instants of the last flight, an object each."""
        begins = max(i for i, line in enumerate(self.had()) if "flight" in line)
        names = self.lines[begins]["flight"]["columns"]
        return [dict(zip(names, row)) for line in self.lines[begins:] for row in line.get("rows", [])]

    def events(self):
        """The texts of what has happened."""
        return [line["event"]["text"] for line in self.had() if "event" in line]

    def state(self):
        """What was known on the link at the end."""
        return {name: words for name, words, _ in [line["state"] for line in self.had() if "state" in line][-1]}
