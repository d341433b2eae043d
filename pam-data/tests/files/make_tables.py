"""Writes the tables of other formats: `pip install numpy pyarrow h5py mcap lz4 mcap-ros2-support`, then `python make_tables.py`."""

import json
import math
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap.writer import CompressionType, Writer
from mcap_ros2.writer import Writer as RosWriter

HERE = Path(__file__).parent
N = 200
t = np.arange(N) / 100.0
angle = 10 * np.sin(2 * math.pi * t)
p1 = 3.0 - 0.05 * angle
p2 = 3.0 + 0.05 * angle
torque = 0.2 * angle

columns = {"t": t, "angle": angle, "p1": p1, "p2": p2, "torque": torque}
pq.write_table(pa.table({**columns, "note": ["text"] * N}), HERE / "run.parquet", compression="snappy")
pq.write_table(pa.table(columns), HERE / "run.zstd.parquet", compression="zstd")

# As MATLAB writes it: a user block of 512 bytes, arrays of one row, compressed, with their class.
with h5py.File(HERE / "run73.mat", "w", userblock_size=512, libver="earliest") as f:
    for name, values in columns.items():
        d = f.create_dataset(name, data=values.reshape(1, -1), compression="gzip", chunks=True)
        d.attrs["MATLAB_class"] = np.bytes_("double")
    f.create_dataset("count", data=np.array([[7]], dtype=np.int32)).attrs["MATLAB_class"] = np.bytes_("int32")
    text = np.frombuffer("elbow".encode("utf-16-le"), dtype=np.uint16).reshape(-1, 1)
    f.create_dataset("label", data=text).attrs["MATLAB_class"] = np.bytes_("char")
raw = bytearray((HERE / "run73.mat").read_bytes())
header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2024 HDF5 schema 1.00 ."
raw[:128] = header.ljust(116, b" ") + bytes(8) + b"\x00\x02IM"
(HERE / "run73.mat").write_bytes(raw)

START = 1_700_000_000_000_000_000

# JSON messages: the pressures come at half the rate of the angle.
for name, compression in [("json.mcap", CompressionType.ZSTD), ("json.lz4.mcap", CompressionType.LZ4)]:
    with open(HERE / name, "wb") as f:
        w = Writer(f, compression=compression)
        w.start()
        schema = w.register_schema("any", "jsonschema", b"{}")
        drive = w.register_channel("/drive", "json", schema)
        air = w.register_channel("/air", "json", schema)
        for k in range(N):
            at = START + k * 10_000_000
            if k % 2 == 0:
                w.add_message(air, at, json.dumps({"p": [p1[k], p2[k]], "unit": "bar"}).encode(), at)
            w.add_message(drive, at, json.dumps({"angle": {"deg": angle[k]}, "torque": torque[k]}).encode(), at)
        w.finish()

JOINT = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
AIR = "uint8 BAR=1\nuint8 unit\nfloat32[2] pressure\n"
with open(HERE / "ros2.mcap", "wb") as f:
    w = RosWriter(f)
    joint = w.register_msgdef("sensor_msgs/msg/JointState", JOINT)
    air = w.register_msgdef("lab_msgs/msg/Air", AIR)
    for k in range(N):
        at = START + k * 10_000_000
        stamp = {"sec": at // 10**9, "nanosec": at % 10**9}
        # The first pressures come after the first joint state.
        if k % 2 == 1:
            w.write_message("/air", air, {"unit": 1, "pressure": [p1[k], p2[k]]}, at - 1000, at)
        message = {
            "header": {"stamp": stamp, "frame_id": "base"},
            "name": ["elbow"],
            "position": [math.radians(angle[k])],
            "velocity": [],
            "effort": [torque[k]],
        }
        w.write_message("/joint_states", joint, message, at, at)
    w.finish()
