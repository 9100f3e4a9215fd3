"""The frames of docs/protocol.md, with nothing but Python's standard library: a start for a host of your own.

    python3 docs/protocol.py           decodes and encodes every vector of docs/figures/protocol-vectors.json
    python3 docs/protocol.py HEX ...   shows what frames from the device say
"""
import json, pathlib, sys, zlib

VERSION, MAX_FRAME = 2, 160


def array(kind, length):
    return ("array", kind, length)


# Fields and variants in the order of docs/protocol.md: the order is what goes over the line.
SEGMENT = ("variant", {"Proximal": None, "Middle": None, "Distal": None})
COMMAND = ("variant", {
    "Run": "text", "Pause": None, "Resume": None, "Vent": None, "Setpoints": array("i32", 3), "ZeroSensors": None,
    "Calibrate": {"segment": SEGMENT, "k": "i32", "c1": "i32", "c2": "i32"},
    "Identify": None, "ClearFault": None, "Beat": None, "Bends": array("i32", 3), "Identification": None,
    "AdoptIdentified": None,
})
REQUEST = {"id": "unsigned", "command": COMMAND}
REASON = ("variant", dict.fromkeys([
    "UnknownSequence", "Faulted", "SetpointOutOfLimits", "CoefficientOutOfLimits", "NotRunning", "NotPaused",
    "NotVented", "CauseStillPresent", "NoFault", "ZeroOutOfLimits", "StorageFailed", "SelfTesting",
    "NothingIdentified"]))
RESET = ("variant", dict.fromkeys(["PowerOn", "Brownout", "Pin", "Software", "Watchdog", "Other"]))
MODE = ("variant", {"Vented": None, "SelfTest": None, "Running": None, "Holding": None, "Paused": None, "Faulted": "u8"})
TELEMETRY = {
    "tick": "unsigned", "mode": MODE, "faults": "unsigned", "priority": "u8", "setpoints": array("i32", 3),
    "estimates": array("i32", 3), "manifold": ("option", "i32"), "bend": ("option", "i32"), "outputs": "u8",
    "step": "unsigned", "repeat": "unsigned", "holding": "bool", "fingertip_um": array("i32", 2),
    "fingertip_millideg": "i32", "force_mn": "i32", "overruns": "unsigned", "dropped_frames": "unsigned",
    "tick_cycles": "unsigned", "worst_tick_cycles": "unsigned",
}
IDENTITY = {
    "id": "unsigned", "protocol": "u8", "firmware": "text", "serial": array("unsigned", 3), "reset_cause": RESET,
    "coefficients": array(array("i32", 3), 3), "pressure_zero": "i32", "bend_zero": "i32", "sequences": "u8",
}
IDENTIFIED = {
    "coefficients": array("i32", 3), "residual_pressure": "i32", "residual_bend": "i32", "points": "unsigned",
    "ready": "bool",
}
REPORT = ("variant", {
    "Telemetry": TELEMETRY, "Ack": {"id": "unsigned"}, "Nack": {"id": "unsigned", "reason": REASON},
    "Identity": IDENTITY, "Identification": {"id": "unsigned", "segments": array(IDENTIFIED, 3)},
})


def write(kind, value):
    """The bytes of a value."""
    if kind in ("u8", "bool"):
        return bytes([value])
    if kind == "unsigned":  # a varint: seven bits a byte, the low ones first
        head, rest = value & 0x7F, value >> 7
        return bytes([head | 0x80]) + write(kind, rest) if rest else bytes([head])
    if kind == "i32":  # zigzag: 0, -1, 1, -2 ... become 0, 1, 2, 3 ...
        return write("unsigned", (value << 1 ^ value >> 31) & 0xFFFFFFFF)
    if kind == "text":
        return write("unsigned", len(value.encode())) + value.encode()
    if isinstance(kind, dict):
        return b"".join(write(field, value[name]) for name, field in kind.items())
    if kind[0] == "array":
        return b"".join(write(kind[1], one) for one in value)
    if kind[0] == "option":
        return b"\0" if value is None else b"\1" + write(kind[1], value)
    name, content = (value, None) if isinstance(value, str) else next(iter(value.items()))
    number = write("unsigned", list(kind[1]).index(name))
    return number if kind[1][name] is None else number + write(kind[1][name], content)


def read(kind, data, at=0):
    """The value at a place in the bytes, and the place after it; IndexError or ValueError when there is none."""
    if kind == "u8":
        return data[at], at + 1
    if kind == "bool":
        if data[at] > 1:
            raise ValueError("no bool")
        return data[at] == 1, at + 1
    if kind == "unsigned":
        value, shift = 0, 0
        while True:
            value |= (data[at] & 0x7F) << shift
            at, shift = at + 1, shift + 7
            if data[at - 1] < 0x80:
                return value, at
    if kind == "i32":
        value, at = read("unsigned", data, at)
        return value >> 1 ^ -(value & 1), at
    if kind == "text":
        length, at = read("unsigned", data, at)
        if at + length > len(data):
            raise IndexError("text ends early")
        return bytes(data[at:at + length]).decode(), at + length
    if isinstance(kind, dict):
        fields = {}
        for name, field in kind.items():
            fields[name], at = read(field, data, at)
        return fields, at
    if kind[0] == "array":
        values = []
        for _ in range(kind[2]):
            value, at = read(kind[1], data, at)
            values.append(value)
        return values, at
    if kind[0] == "option":
        there, at = read("bool", data, at)
        return read(kind[1], data, at) if there else (None, at)
    number, at = read("unsigned", data, at)
    name, content = list(kind[1].items())[number]
    if content is None:
        return name, at
    value, at = read(content, data, at)
    return {name: value}, at


def encode(kind, message):
    """A message as a frame, its zero included."""
    plain = bytes([VERSION]) + write(kind, message)
    plain += zlib.crc32(plain).to_bytes(4, "little")
    # COBS: each zero becomes the distance to the next. A frame is shorter than 254 bytes, so no block fills up.
    return b"".join(bytes([len(block) + 1]) + block for block in plain.split(b"\0")) + b"\0"


def decode(kind, frame):
    """The message of a frame without its zero; None when it is damaged, of another version or no message."""
    plain, at = b"", 0
    while at < len(frame):
        end = at + frame[at]
        if frame[at] == 0 or end > len(frame):
            return None
        plain += frame[at + 1:end] + (b"\0" if end < len(frame) else b"")
        at = end
    if len(frame) > MAX_FRAME or len(plain) < 6 or zlib.crc32(plain[:-4]) != int.from_bytes(plain[-4:], "little"):
        return None
    if plain[0] != VERSION:
        return None
    try:
        message, end = read(kind, plain[1:-4])
    except (IndexError, ValueError):
        return None
    return message if end == len(plain) - 5 else None


def check(path):
    """Every vector, both ways."""
    vectors = json.loads(path.read_text())
    count = 0
    for name, kind in (("requests", REQUEST), ("reports", REPORT)):
        for vector in vectors[name]:
            frame = bytes.fromhex(vector["frame_hex"])
            assert decode(kind, frame[:-1]) == vector["message"], vector
            assert encode(kind, vector["message"]) == frame, vector
            count += 1
    for vector in vectors["refused_requests"]:
        frame = bytes.fromhex(vector["frame_hex"])
        assert all(decode(REQUEST, part) is None for part in frame.split(b"\0")), vector
        count += 1
    print(f"{count} vectors hold")


if __name__ == "__main__":
    if sys.argv[1:]:
        for text in sys.argv[1:]:
            print(json.dumps(decode(REPORT, bytes.fromhex(text).rstrip(b"\0"))))
    else:
        check(pathlib.Path(__file__).parent / "figures" / "protocol-vectors.json")
