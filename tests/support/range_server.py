#!/usr/bin/env python3
"""Serves the files of a folder over HTTP with range requests, as web servers do (python3 -m
http.server has none). The last line of LOG is the sum: requests and bytes of content sent.

    range_server.py FOLDER PORT LOG      PORT 0: a free one; the first line of LOG has it
"""
import http.server
import os
import re
import sys

folder, port, log = sys.argv[1], int(sys.argv[2]), open(sys.argv[3], "w", buffering=1)
total = {"requests": 0, "bytes": 0}


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_GET(self):
        path = os.path.join(folder, os.path.basename(self.path.split("?")[0]))
        if not os.path.isfile(path):
            self.send_error(404)
            return
        size = os.path.getsize(path)
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        first, last = (int(wanted[1]), min(int(wanted[2]), size - 1)) if wanted else (0, size - 1)
        self.send_response(206 if wanted else 200)
        if wanted:
            self.send_header("Content-Range", f"bytes {first}-{last}/{size}")
        self.send_header("ETag", f'"{os.stat(path).st_mtime_ns:x}-{size:x}"')
        self.send_header("Content-Length", str(last - first + 1))
        self.end_headers()
        with open(path, "rb") as file:
            file.seek(first)
            self.wfile.write(file.read(last - first + 1))
        total["requests"] += 1
        total["bytes"] += last - first + 1
        log.write(f"{total['requests']} {total['bytes']}\n")

    def log_message(self, *_):
        pass


server = http.server.ThreadingHTTPServer(("127.0.0.1", port), Handler)
log.write(f"{server.server_address[1]}\n")
server.serve_forever()
