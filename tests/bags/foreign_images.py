#!/usr/bin/env python3
"""Images in all encodings, and ROS 1 bags and rosbag2 databases of them, written by Debian's python3-rosbag and sqlite3.

  foreign_images.py images DIR              DIR/images.json and the pixels; DIR/expected.txt by OpenCV
  foreign_images.py ros1 DIR OUT COMPRESSION    OUT.bag by rosbag (none, lz4, bz2)
  foreign_images.py rosbag2 DIR OUT         OUT.db3 of DIR/messages.bin, the messages that foreign_mcap.mjs serialized
"""
import json
import os
import struct
import sys
import zlib

import cv2
import numpy as np

from rosbag2_database import write_database

WIDTH, HEIGHT, IMAGES = 64, 40, 3
START_S = 1700000000

# Encoding: numpy type and channels, OpenCV's codes to grey and to BGR (None: as it is).
ENCODINGS = {
    "mono8": ("u1", 1, None, cv2.COLOR_GRAY2BGR),
    "mono16": ("<u2", 1, None, cv2.COLOR_GRAY2BGR),
    "rgb8": ("u1", 3, cv2.COLOR_RGB2GRAY, cv2.COLOR_RGB2BGR),
    "bgr8": ("u1", 3, cv2.COLOR_BGR2GRAY, None),
    "rgba8": ("u1", 4, cv2.COLOR_RGBA2GRAY, cv2.COLOR_RGBA2BGR),
    "bgra8": ("u1", 4, cv2.COLOR_BGRA2GRAY, cv2.COLOR_BGRA2BGR),
    "yuv422": ("u1", 2, cv2.COLOR_YUV2GRAY_UYVY, cv2.COLOR_YUV2BGR_UYVY),
    "yuv422_yuy2": ("u1", 2, cv2.COLOR_YUV2GRAY_YUY2, cv2.COLOR_YUV2BGR_YUY2),
    "bayer_rggb8": ("u1", 1, cv2.COLOR_BayerRGGB2GRAY, cv2.COLOR_BayerRGGB2BGR),
    "bayer_bggr8": ("u1", 1, cv2.COLOR_BayerBGGR2GRAY, cv2.COLOR_BayerBGGR2BGR),
    "bayer_gbrg8": ("u1", 1, cv2.COLOR_BayerGBRG2GRAY, cv2.COLOR_BayerGBRG2BGR),
    "bayer_grbg8": ("u1", 1, cv2.COLOR_BayerGRBG2GRAY, cv2.COLOR_BayerGRBG2BGR),
    "bayer_rggb16": (">u2", 1, cv2.COLOR_BayerRGGB2GRAY, cv2.COLOR_BayerRGGB2BGR),
    "jpeg": ("u1", 3, cv2.COLOR_BGR2GRAY, None),
    "png": ("u1", 3, cv2.COLOR_BGR2GRAY, None),
}


def pixels(encoding, index):
    kind, channels, _, _ = ENCODINGS[encoding]
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    random = np.random.default_rng(index)
    top = 65535 if kind.endswith("u2") else 255
    planes = [(np.sin(u / (5 + c) + index) * np.cos(v / 7) + 1) / 2.2 * top + random.integers(0, top // 16, u.shape)
              for c in range(channels)]
    image = np.stack(planes, axis=-1).astype(kind)
    return image[:, :, 0] if channels == 1 else image


def to_8_bits(image):
    return image if image.dtype == np.uint8 else cv2.convertScaleAbs(image, alpha=1 / 257)


def checksums(image, encoding):
    _, _, grey, bgr = ENCODINGS[encoding]
    native = image.astype(image.dtype.newbyteorder("="))
    converted = [native if code is None else cv2.cvtColor(native, code) for code in (grey, bgr)]
    return " ".join("%08x" % zlib.crc32(to_8_bits(c).tobytes()) for c in converted)


def write_images(folder):
    images, expected = [], []
    for number, encoding in enumerate(ENCODINGS):
        for index in range(IMAGES):
            image = pixels(encoding, index)
            compressed = encoding in ("jpeg", "png")
            data = image.tobytes()
            if compressed:
                data = cv2.imencode("." + encoding, image)[1].tobytes()
                image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
            name = "%s-%d.raw" % (encoding, index)
            with open(os.path.join(folder, name), "wb") as file:
                file.write(data)
            nanoseconds = index * 100000000 + number * 1000
            images.append({
                "topic": "/%s/%s" % (encoding, "compressed" if compressed else "image_raw"), "encoding": encoding,
                "compressed": compressed, "file": name, "seconds": START_S, "nanoseconds": nanoseconds,
                "width": WIDTH, "height": HEIGHT, "step": len(data) // HEIGHT,
                "is_bigendian": int(ENCODINGS[encoding][0].startswith(">"))})
            stamp = START_S * 10**9 + nanoseconds
            expected.append((stamp, "%s %d %d %s" % (images[-1]["topic"], stamp, stamp, checksums(image, encoding))))
    images.sort(key=lambda image: image["nanoseconds"])
    with open(os.path.join(folder, "images.json"), "w") as file:
        json.dump(images, file, indent=1)
    with open(os.path.join(folder, "expected.txt"), "w") as file:
        file.writelines(line + "\n" for _, line in sorted(expected))


def read_images(folder):
    with open(os.path.join(folder, "images.json")) as file:
        for image in json.load(file):
            with open(os.path.join(folder, image["file"]), "rb") as pixels_file:
                yield image, pixels_file.read()


def write_ros1(folder, out, compression):
    import genpy
    import rosbag
    from sensor_msgs.msg import CompressedImage, Image

    with rosbag.Bag(out, "w", compression=compression, chunk_threshold=20000) as bag:
        for image, data in read_images(folder):
            stamp = genpy.Time(image["seconds"], image["nanoseconds"])
            message = CompressedImage() if image["compressed"] else Image()
            message.header.stamp = stamp
            message.header.frame_id = "camera"
            message.data = data
            if image["compressed"]:
                message.format = image["encoding"]
            else:
                for field in ("width", "height", "step", "is_bigendian", "encoding"):
                    setattr(message, field, image[field])
            bag.write(image["topic"], message, stamp)


def write_rosbag2(folder, out):
    def rows():
        with open(os.path.join(folder, "messages.bin"), "rb") as file:
            for image, _ in read_images(folder):
                data = file.read(struct.unpack("<I", file.read(4))[0])
                kind = "sensor_msgs/msg/" + ("CompressedImage" if image["compressed"] else "Image")
                yield image["topic"], kind, image["seconds"] * 10**9 + image["nanoseconds"], data

    write_database(out, rows())


def main():
    command = sys.argv[1] if len(sys.argv) > 1 else ""
    if command == "images" and len(sys.argv) == 3:
        write_images(sys.argv[2])
    elif command == "ros1" and len(sys.argv) == 5:
        write_ros1(*sys.argv[2:])
    elif command == "rosbag2" and len(sys.argv) == 4:
        write_rosbag2(*sys.argv[2:])
    else:
        sys.exit(__doc__)


main()
