"""A subscriber that connects and then reads nothing; it speaks TCPROS over a plain socket."""
import socket
import struct


def tcpros_header(fields):
    entries = b"".join(struct.pack("<I", len(entry)) + entry for entry in (
        f"{name}={value}".encode() for name, value in fields.items()))
    return struct.pack("<I", len(entries)) + entries


class DeafSubscriber:
    """Of a node's topic. With `mute`, it does not even say what it wants."""

    def __init__(self, node_api, topic, message_type, caller="/deaf", mute=False):
        code, text, parameters = node_api.requestTopic(caller, topic, [["TCPROS"]])
        if code != 1:
            raise AssertionError(f"no connection to {topic}: {text}")
        self.socket = socket.socket()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.connect((parameters[1], parameters[2]))
        if mute:
            return
        self.socket.sendall(tcpros_header({
            "callerid": caller, "topic": topic, "type": message_type._type,
            "md5sum": message_type._md5sum, "tcp_nodelay": "0"}))

    def is_connected(self):
        """False once the other side has gone; reads nothing."""
        established = 1
        return self.socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 1)[0] == established

    def close(self):
        self.socket.close()
