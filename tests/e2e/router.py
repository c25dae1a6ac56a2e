"""A router between a vehicle and its clients, as mavlink-routerd is one: a stand-in that always runs, and mavlink-routerd itself.

Both have a UDP server for the vehicle, which answers whoever has sent last, and a UDP client for whoever listens behind it. With
SAMARA_ROUTERD, the path of mavlink-routerd's program, that is used.
"""

import contextlib
import os
import select
import socket
import threading

ROUTERD = os.environ.get("SAMARA_ROUTERD")


@contextlib.contextmanager
def last_sender_router(vehicle_port, client_port):
    """Passes datagrams on both ways; what comes from the clients goes to the last sender at `vehicle_port` alone."""
    with socket.socket(type=socket.SOCK_DGRAM) as vehicle, socket.socket(type=socket.SOCK_DGRAM) as client:
        vehicle.bind(("127.0.0.1", vehicle_port))
        client.connect(("127.0.0.1", client_port))
        ended = threading.Event()

        def run():
            last_sender = None
            while not ended.is_set():
                for ready in select.select([vehicle, client], [], [], 0.1)[0]:
                    # Nobody may listen there yet.
                    with contextlib.suppress(ConnectionRefusedError):
                        if ready is vehicle:
                            data, last_sender = vehicle.recvfrom(65535)
                            client.send(data)
                        elif last_sender is not None:
                            vehicle.sendto(client.recv(65535), last_sender)

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()


@contextlib.contextmanager
def mavlink_routerd(samara, client_port):
    """mavlink-routerd at the companion's port of an instance."""
    samara.other(
        "mavlink-routerd", ROUTERD, "--tcp-port", 0, "--endpoint", f"127.0.0.1:{client_port}", f"127.0.0.1:{samara.ports.api}"
    )
    yield
