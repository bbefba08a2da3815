import canopen, time
node = canopen.Network().connect(interface="slcan", channel="socket://127.0.0.1:29536", bitrate=125000).add_node(127, canopen.ObjectDictionary())
time.sleep(1); node.nmt.state = "RESET"; node.nmt.wait_for_bootup(); print("node 127 has booted")
for index, sub in [(0x1000, 0), (0x1008, 0), (0x1018, 1), (0x6004, 0)]: print(hex(index), node.sdo.upload(index, sub))
node.network.subscribe(0x280 + 127, lambda cob_id, data, time: print(int.from_bytes(data[:4], "little", signed=True) / 100, "mm", flush=True))
node.nmt.state = "OPERATIONAL"; input("Turn the shaft; Enter ends.\n")
