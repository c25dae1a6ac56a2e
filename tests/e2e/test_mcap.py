"""drop.mcap in the eyes of MCAP's own reader and of Foxglove's published message types; the truth beside it is the simulator's
CSV and the verdict."""

import csv
import math

import pytest
from foxglove_schemas_protobuf import FrameTransforms_pb2, Log_pb2, PointCloud_pb2, SceneUpdate_pb2
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet
from mcap.reader import NonSeekingReader, make_reader
from mcap_protobuf.decoder import DecoderFactory

PUBLISHED = {
    "foxglove.FrameTransforms": FrameTransforms_pb2,
    "foxglove.Log": Log_pb2,
    "foxglove.PointCloud": PointCloud_pb2,
    "foxglove.SceneUpdate": SceneUpdate_pb2,
}


@pytest.fixture(scope="module")
def mcap(reference):
    with open(reference.out / "drop.mcap", "rb") as file:
        yield make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])


@pytest.fixture(scope="module")
def messages(mcap):
    """Messages of a topic: seconds since the mission's epoch, and what they say."""
    topics = {}
    for _, channel, message, content in mcap.iter_decoded_messages():
        topics.setdefault(channel.topic, []).append((message.log_time, content))
    return topics


@pytest.fixture(scope="module")
def truth(reference):
    with open(reference.out / "flight.csv", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def begin_ns(reference):
    return reference.mission["epoch_unix_us"] * 1000


def test_the_file_is_whole(mcap, messages, reference):
    statistics = mcap.get_summary().statistics
    assert statistics.message_count == sum(map(len, messages.values()))
    assert statistics.message_start_time == begin_ns(reference)
    assert statistics.message_end_time == begin_ns(reference) + reference.mission["duration_s"] * 10**9
    with open(reference.out / "drop.mcap", "rb") as file:
        times = [message.log_time for _, _, message in NonSeekingReader(file, validate_crcs=True).iter_messages()]
    assert len(times) == statistics.message_count and times == sorted(times)


def test_the_files_of_the_drop_are_inside(mcap, reference):
    inside = {file.name: file.data.decode() for file in mcap.iter_attachments()}
    assert inside["drop.json"] == (reference.out / "drop.json").read_text(encoding="utf-8")
    assert set(inside) == {"drop.json", "mission.json", "vehicle.json", "gains.json"}
    (about,) = mcap.iter_metadata()
    assert about.metadata["input_hash"] == reference.verdict["input_hash"]
    assert float(about.metadata["j_tpf"]) == reference.verdict["j_tpf"]


def test_the_types_are_those_that_foxglove_publishes(mcap):
    for schema in mcap.get_summary().schemas.values():
        if schema.name not in PUBLISHED:
            continue
        inside = {file.name: file for file in FileDescriptorSet.FromString(schema.data).file}
        missing = [PUBLISHED[schema.name].DESCRIPTOR]
        while missing:
            file = missing.pop()
            published = FileDescriptorProto()
            file.CopyToProto(published)
            assert inside[file.name] == published
            missing += file.dependencies


def test_the_state_has_every_number_of_the_table(messages, truth):
    states = [state for _, state in messages["/state"]]
    assert len(states) == len(truth)
    for name in truth[0]:
        values = [getattr(state, name) for state in states]
        if name == "phase":
            assert values == [row[name] for row in truth]
            continue
        expected = [float(row[name] or "nan") for row in truth]
        assert all(a == b or math.isnan(a) and math.isnan(b) for a, b in zip(values, expected)), name


def test_the_frames_are_where_the_vehicle_is(messages, truth, reference):
    (_, fixed), = messages["/tf_static"]
    assert (fixed.transforms[0].parent_frame_id, fixed.transforms[0].child_frame_id) == ("map", "map_ned")
    q = fixed.transforms[0].rotation
    for (log_time, message), row in zip(messages["/tf"], truth, strict=True):
        (placed,) = message.transforms
        assert (placed.parent_frame_id, placed.child_frame_id) == ("map_ned", "base_link_frd")
        at = placed.translation
        assert [at.x, at.y, at.z] == [float(row[name]) for name in ("north_m", "east_m", "down_m")]
        turn = placed.rotation
        assert [turn.w, turn.x, turn.y, turn.z] == [float(row[f"q{i}"]) for i in range(4)]
        assert log_time == begin_ns(reference) + round(float(row["t_s"]) * 1e9)
        assert placed.timestamp.ToNanoseconds() == log_time
    # Rodrigues' formula for a unit quaternion: north is the y of the map, east its x, down opposite to its z.
    for axis, image in [((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (1, 0, 0)), ((0, 0, 1), (0, 0, -1))]:
        u, w = (q.x, q.y, q.z), q.w
        dot, square = sum(a * b for a, b in zip(u, axis)), sum(a * a for a in u)
        cross = (u[1] * axis[2] - u[2] * axis[1], u[2] * axis[0] - u[0] * axis[2], u[0] * axis[1] - u[1] * axis[0])
        turned = [2 * dot * u[i] + (w * w - square) * axis[i] + 2 * w * cross[i] for i in range(3)]
        assert turned == pytest.approx(image, abs=1e-15)


def test_what_happened_is_in_the_log(messages, reference):
    said = {(round((t - begin_ns(reference)) / 1e9, 6), event.message) for t, event in messages["/events"]}
    assert {(round(event["t_s"], 6), event["text"]) for event in reference.verdict["events"]} <= said
    assert any("steady" in text for _, text in said)


def test_the_scene_shows_vehicle_thrusts_canopy_and_paths(messages, truth):
    (_, vehicle), = messages["/vehicle"]
    (picture,) = vehicle.entities
    assert picture.frame_id == "base_link_frd" and len(picture.cylinders) == 1 + 4
    hanging, released = (update for _, update in messages["/canopy"])
    assert hanging.entities[0].id == released.deletions[0].id == "canopy"
    (_, path), = messages["/path"]
    last = path.entities[0].lines[0].points[-1]
    assert last.z == pytest.approx(float(truth[-1]["down_m"]), abs=0.2)
    (_, points), = messages["/path/points"]
    assert len(points.data) == points.point_stride * len(path.entities[0].lines[0].points)
    # The arrows are as long as the thrust is large: the longest shows the largest.
    longest = [max((a.shaft_length + a.head_length for a in u.entities[0].arrows), default=0) for _, u in messages["/thrust"]]
    thrust = [max(float(row[f"thrust_{i}_n"]) for i in range(1, 5)) for row in truth[::5]]
    for length, newton in zip(longest, thrust, strict=True):
        if newton > 10:
            assert length / newton == pytest.approx(longest[-1] / thrust[-1], rel=1e-9)
