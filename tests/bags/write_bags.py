#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""write_bags.py encodings|rig|long DRIVE OUT: the frames of a simulated drive as folders of images and as bags.

OUT/folders/NAME are drives in folders, OUT/bags/NAME.* the same in ROS 1 bags (Debian's python3-rosbag) and .db3 files
(sqlite3), and OUT/mcap.json is the plan of the MCAP files for write_mcap.js. OUT/pairs.txt has a line per bag: its file,
the folder that has to give the same trajectory, and the topic where one has to be named. For `long`, OUT/bags has bags
of 30 and of 900 images, all alike.
"""
import json
import pathlib
import re
import shutil
import sqlite3
import struct
import sys

import genpy
import numpy as np
import rosbag
from PIL import Image
from sensor_msgs.msg import CameraInfo, CompressedImage
from sensor_msgs.msg import Image as ImageMessage

TOPIC = "/camera/image_raw"
# The recorder's clock in nanoseconds, with more digits than a double has.
STAMPS = [1_700_000_000_123_456_789 + i * 100_000_000 + i * i * 7_919 for i in range(1000)]
BAYER = ("rggb", "bggr", "gbrg", "grbg")


def intrinsics(drive):
    """fx, fy, cx, cy of camera.yaml."""
    data = re.search(r"camera_matrix:.*?data: \[(.*?)\]", (drive / "camera.yaml").read_text(), re.DOTALL)[1]
    matrix = [float(word) for word in data.split(",")]
    return matrix[0], matrix[4], matrix[2], matrix[5]


def colours(gray):
    """Red, green and blue of an image of which the gray alone would not tell the colours."""
    gray = gray.astype(int)
    return np.stack([255 - (255 - gray) // 2, gray, gray // 3], axis=-1).astype(np.uint8)


def mosaic(rgb, pattern):
    """What a sensor behind a colour filter sees."""
    seen = np.empty(rgb.shape[:2], np.uint8)
    for i, colour in enumerate(pattern):
        y, x = divmod(i, 2)
        seen[y::2, x::2] = rgb[y::2, x::2, "rgb".index(colour)]
    return seen


def interpolated(seen, pattern):
    """Bilinear interpolation of a colour filter; the outermost pixels are those beside them."""
    height, width = seen.shape
    colour_at = np.array([["rgb".index(pattern[2 * (y % 2) + x % 2]) for x in range(width)] for y in range(height)])
    padded = np.pad(seen.astype(int), 1)
    here = lambda dy, dx: padded[1 + dy:height + 1 + dy, 1 + dx:width + 1 + dx]
    sides = (here(0, -1) + here(0, 1) + 1) // 2
    above = (here(-1, 0) + here(1, 0) + 1) // 2
    cross = (here(0, -1) + here(0, 1) + here(-1, 0) + here(1, 0) + 2) // 4
    corners = (here(-1, -1) + here(-1, 1) + here(1, -1) + here(1, 1) + 2) // 4
    beside = np.roll(colour_at, 1, axis=1)
    rgb = np.empty((height, width, 3), np.uint8)
    green = colour_at == 1
    for colour in range(3):
        value = np.where(beside == colour, sides, above) if colour != 1 else np.where(green, seen, cross)
        if colour != 1:
            value = np.where(green, value, corners)
        rgb[..., colour] = np.where(colour_at == colour, seen, value)
    inner = rgb[1:-1, 1:-1]
    return np.pad(inner, ((1, 1), (1, 1), (0, 0)), mode="edge")


class Writer:
    def __init__(self, drive, out):
        self.drive = drive
        self.out = out
        self.images = sorted((drive / "image_0").glob("*.png"))
        self.grays = [np.array(Image.open(path)) for path in self.images]
        self.pairs = []
        self.plan = []
        for name in ("folders", "bags", "raw"):
            (out / name).mkdir(parents=True)

    def folder(self, name, save, extension=".png"):
        """A drive in a folder; `save` writes an image of it."""
        folder = self.out / "folders" / name
        (folder / "image_0").mkdir(parents=True)
        shutil.copy(self.drive / "camera.yaml", folder)
        stamps = STAMPS[:len(self.grays)]
        (folder / "times.txt").write_text("".join(f"{t // 10**9}.{t % 10**9:09}\n" for t in stamps))
        for i, gray in enumerate(self.grays):
            save(gray, folder / "image_0" / f"{i:06}{extension}")
        return sorted((folder / "image_0").iterdir())

    def camera_info(self, width, height, pinhole):
        fx, fy, cx, cy = pinhole
        return {"height": height, "width": width, "distortion_model": "plumb_bob", "d": [0.0] * 5,
                "k": [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0], "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
                "p": [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0], "binning_x": 0, "binning_y": 0,
                "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}}

    def messages(self, name, encoding, arrays, topic=TOPIC):
        """Images and their camera infos; `arrays` are pixels, or the bytes of image files."""
        height, width = self.grays[0].shape
        info = self.camera_info(width, height, intrinsics(self.drive))
        messages = []
        for i, array in enumerate(arrays):
            raw = self.out / "raw" / f"{name}_{i}"
            raw.write_bytes(array if isinstance(array, bytes) else array.tobytes())
            stamp = STAMPS[i]
            messages.append({"topic": topic.rsplit("/", 1)[0] + "/camera_info", "type": "CameraInfo", "stamp": str(stamp),
                             "fields": info})
            if isinstance(array, bytes):
                messages.append({"topic": topic + "/compressed", "type": "CompressedImage", "stamp": str(stamp),
                                 "data": str(raw), "fields": {"format": encoding}})
            else:
                fields = {"height": height, "width": width, "encoding": encoding, "is_bigendian": 0,
                          "step": array.strides[0]}
                messages.append({"topic": topic, "type": "Image", "stamp": str(stamp), "data": str(raw),
                                 "fields": fields})
        return messages

    def pair(self, path, folder, topic=""):
        self.pairs.append(f"{path} {self.out / 'folders' / folder} {topic}".rstrip())

    def write_all(self, name, encoding, arrays, folder):
        """The images in every container and compression."""
        messages = self.messages(name, encoding, arrays)
        bags = self.out / "bags"
        for compression in ("none", "bz2", "lz4"):
            path = bags / f"{name}_{compression}.bag"
            write_ros1(path, messages, compression)
            self.pair(path, folder)
        for compression, indexed, chunks in (("none", True, True), ("lz4", True, True), ("zstd", True, True),
                                             ("zstd", False, True), ("none", False, False)):
            kind = compression + ("" if indexed else "_unindexed") + ("" if chunks else "_unchunked")
            path = bags / f"{name}_{kind}.mcap"
            self.plan.append({"path": str(path), "compression": compression, "indexed": indexed, "chunks": chunks,
                              "messages": messages})
            self.pair(path, folder)
        path = bags / f"{name}.db3"
        write_db3(path, messages)
        self.pair(path, folder)

    def finish(self):
        (self.out / "mcap.json").write_text(json.dumps(self.plan))
        (self.out / "pairs.txt").write_text("\n".join(self.pairs) + "\n")


def ros1_message(message):
    fields = message["fields"]
    if message["type"] == "CameraInfo":
        made = CameraInfo(height=fields["height"], width=fields["width"], distortion_model=fields["distortion_model"],
                          D=fields["d"], K=fields["k"], R=fields["r"], P=fields["p"])
    elif message["type"] == "Image":
        made = ImageMessage(data=pathlib.Path(message["data"]).read_bytes(), **fields)
    else:
        made = CompressedImage(data=pathlib.Path(message["data"]).read_bytes(), **fields)
    made.header.stamp = genpy.Time(*divmod(int(message["stamp"]), 10**9))
    made.header.frame_id = "camera"
    return made


def write_ros1(path, messages, compression):
    with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=300_000) as bag:
        for message in messages:
            logged = genpy.Time(*divmod(int(message["stamp"]) + 1_000_000, 10**9))
            bag.write(message["topic"], ros1_message(message), logged)


class Cdr:
    """CDR, little-endian, as ROS 2 writes it."""

    def __init__(self):
        self.bytes = bytearray(b"\0\1\0\0")

    def add(self, kind, *values):
        size = struct.calcsize(kind)
        for value in values:
            self.bytes += b"\0" * (-(len(self.bytes) - 4) % size) + struct.pack("<" + kind, value)

    def text(self, text):
        self.add("I", len(text) + 1)
        self.bytes += text.encode() + b"\0"

    def message(self, message):
        fields = message["fields"]
        self.add("I", *divmod(int(message["stamp"]), 10**9))
        self.text("camera")
        if message["type"] == "CompressedImage":
            self.text(fields["format"])
        else:
            self.add("I", fields["height"], fields["width"])
        if message["type"] == "Image":
            self.text(fields["encoding"])
            self.add("B", fields["is_bigendian"])
            self.add("I", fields["step"])
        if message["type"] == "CameraInfo":
            self.text(fields["distortion_model"])
            self.add("I", len(fields["d"]))
            self.add("d", *fields["d"], *fields["k"], *fields["r"], *fields["p"])
            self.add("I", 0, 0, 0, 0, 0, 0)
            self.add("B", 0)
        else:
            data = pathlib.Path(message["data"]).read_bytes()
            self.add("I", len(data))
            self.bytes += data
        return bytes(self.bytes)


def write_db3(path, messages):
    """The tables of rosbag2's sqlite3 storage."""
    database = sqlite3.connect(path)
    database.executescript(
        "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
        "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,metadata TEXT NOT NULL);"
        "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
        "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL,"
        "data BLOB NOT NULL);"
        "CREATE INDEX timestamp_idx ON messages (timestamp ASC);")
    ids = {}
    for message in messages:
        topic = message["topic"]
        if topic not in ids:
            ids[topic] = len(ids) + 1
            database.execute("INSERT INTO topics VALUES(?,?,?,'cdr','')",
                             (ids[topic], topic, f"sensor_msgs/msg/{message['type']}"))
        database.execute("INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)",
                         (ids[topic], int(message["stamp"]) + 1_000_000, Cdr().message(message)))
    database.commit()
    database.close()


def write_encodings(writer):
    grays = writer.grays
    save = lambda array, path: Image.fromarray(array).save(path)
    mono = writer.folder("mono8", save)
    writer.write_all("mono8", "mono8", grays, "mono8")
    writer.write_all("png", "mono8; png compressed ", [path.read_bytes() for path in mono], "mono8")
    jpegs = writer.folder("jpeg", lambda gray, path: Image.fromarray(gray).save(path, quality=90), ".jpg")
    writer.write_all("jpeg", "jpeg", [path.read_bytes() for path in jpegs], "jpeg")
    deep = [gray.astype(np.uint16) * 250 + 77 for gray in grays]
    folder = writer.folder("mono16", lambda gray, path: Image.fromarray(gray.astype(np.uint16) * 250 + 77).save(path))
    assert np.array_equal(np.array(Image.open(folder[0])), deep[0])
    writer.write_all("mono16", "mono16", deep, "mono16")
    writer.folder("colour", lambda gray, path: save(colours(gray), path))
    writer.write_all("rgb8", "rgb8", [colours(gray) for gray in grays], "colour")
    writer.write_all("bgr8", "bgr8", [np.ascontiguousarray(colours(gray)[..., ::-1]) for gray in grays], "colour")
    for pattern in BAYER:
        name = "bayer_" + pattern
        writer.folder(name, lambda gray, path: save(interpolated(mosaic(colours(gray), pattern), pattern), path))
        writer.write_all(name, name + "8", [mosaic(colours(gray), pattern) for gray in grays], name)


def write_rig(writer):
    """The garage rig of the paper: two cameras of 1032x772 pixels at 10 Hz, in one bag of ROS 1 and one MCAP file."""
    writer.folder("rig_front", lambda gray, path: Image.fromarray(gray).save(path))
    writer.folder("rig_rear", lambda gray, path: Image.fromarray(np.ascontiguousarray(gray[:, ::-1])).save(path))
    front = writer.messages("front", "mono8", writer.grays, "/front/image_raw")
    rear = writer.messages("rear", "mono8", [np.ascontiguousarray(gray[:, ::-1]) for gray in writer.grays],
                           "/rear/image_raw")
    both = [message for pair in zip(front, rear) for message in pair]
    write_ros1(writer.out / "bags" / "rig.bag", both, "lz4")
    writer.plan.append({"path": str(writer.out / "bags" / "rig.mcap"), "compression": "zstd", "indexed": True,
                        "chunks": True, "messages": both})
    for name in ("rig.bag", "rig.mcap"):
        for camera in ("front", "rear"):
            writer.pair(writer.out / "bags" / name, "rig_" + camera, f"/{camera}/image_raw")


def write_parts(writer):
    """The drive in two bags, and one that breaks off."""
    messages = writer.messages("parts", "mono8", writer.grays)
    half = len(messages) // 2
    bags = writer.out / "bags"
    write_ros1(bags / "part1.bag", messages[:half], "lz4")
    write_ros1(bags / "part2.bag", messages[half:], "none")
    whole = (bags / "mono8_none.bag").read_bytes()
    (bags / "broken.bag").write_bytes(whole[:len(whole) * 2 // 3])


def write_long(writer):
    """A few and many images in each container: noise, which cannot be compressed."""
    noise = np.random.default_rng(1).integers(0, 255, writer.grays[0].shape, dtype=np.uint8)
    info, image = writer.messages("noise", "mono8", [noise])
    for name, count in (("short", 30), ("long", 900)):
        messages = [{**message, "stamp": str(stamp)} for stamp in STAMPS[:count] for message in (info, image)]
        for compression in ("none", "lz4"):
            write_ros1(writer.out / "bags" / f"{name}_{compression}.bag", messages, compression)
        write_db3(writer.out / "bags" / f"{name}.db3", messages)
        for compression, indexed in (("zstd", True), ("none", False)):
            path = writer.out / "bags" / f"{name}_{compression}.mcap"
            writer.plan.append({"path": str(path), "compression": compression, "indexed": indexed, "chunks": indexed,
                                "messages": messages})


def main():
    kind, drive, out = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(out, ignore_errors=True)
    writer = Writer(drive, out)
    if kind == "rig":
        write_rig(writer)
    elif kind == "long":
        write_long(writer)
    else:
        write_encodings(writer)
        write_parts(writer)
    writer.finish()


main()
