"""Router of eclipse-zenoh, as rmw_zenohd: listens on the loopback until it is ended."""

import signal

import zenoh

config = zenoh.Config()
config.insert_json5("mode", '"router"')
config.insert_json5("listen/endpoints", '["tcp/127.0.0.1:7447"]')
config.insert_json5("scouting/multicast/enabled", "false")
with zenoh.open(config):
    print("ready", flush=True)
    signal.pause()
