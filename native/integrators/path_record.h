// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the segments of a path until all that comes of them is known, and turns each into a lesson: what the
// light that came back tells about the vertex that the segment left.
#pragma once

#include "integrators/path_state.h"

namespace nephele {

class PathRecord {
  public:
    PathRecord(const SampleRequest& request, Workspace& ws) : request_(request), ws_(ws) { ws_.open.clear(); }

    /// A segment begins; light: of the path so far.
    void open(OpenSegment segment, Rgb light) {
        segment.before = light;
        segment.guiding.start(ws_.counters);
        ws_.open.push_back(segment);
    }
    /// The current segment's work begins only now.
    void start() { ws_.open.back().guiding.start(ws_.counters); }
    /// The path leaves its first vertex, and nothing is kept of what follows.
    void leave() { left_ = true; }

    /// The segment that the path is on; null where nothing is kept of it.
    OpenSegment* current() { return left_ ? nullptr : &ws_.open.back(); }
    std::size_t size() const { return ws_.open.size(); }

    /// The current segment ends in a vertex, so far from its start.
    void arrive(float distance) {
        if (!left_)
            ws_.open.back().vertex.distance = distance;
    }

    /// All segments from number `first` on have ended. light: of the path so far.
    void close(std::size_t first, Rgb light) {
        while (ws_.open.size() > first) {
            OpenSegment& segment = ws_.open.back();
            if (segment.vertex.pdf > 0 && request_.teaches)
                teach(segment, light);
            ws_.open.pop_back();
        }
    }

    /// The camera's segment has ended, the last. Returns the work of the path.
    float close_camera(Rgb light, VspRecord& record, float& target) {
        OpenSegment& camera = ws_.open.front();
        const Rgb decided = light - camera.before - camera.undecided;
        record = camera.guiding.finish(decided, camera.gathered, ws_.counters);
        target = camera.guiding.target();
        constexpr float kPath = 15;  // what every path costs, however short
        return record.cost + kPath;
    }

  private:
    void teach(OpenSegment& segment, Rgb light) {
        const Rgb brought = light - segment.before;
        FieldSample& lesson = segment.vertex;
        lesson.vsp = segment.guiding.finish(brought - segment.undecided, segment.gathered, ws_.counters);
        lesson.light = mean(brought) / segment.guiding.beta();
        lesson.cost = lesson.vsp.cost;
        lesson.key = hash_combine(request_.key, number_++);
        ws_.lessons.push_back(lesson);
    }

    const SampleRequest& request_;
    Workspace& ws_;
    bool left_ = false;
    std::uint64_t number_ = 0;  // of the next lesson of this path
};

/// Of a path that teaches nothing, and that nothing learned guides.
class NoPathRecord {
  public:
    NoPathRecord(const SampleRequest&, Workspace&) {}

    void open(const OpenSegment&, Rgb) {}
    void start() {}
    void leave() {}
    static constexpr OpenSegment* current() { return nullptr; }
    static constexpr std::size_t size() { return 0; }
    void arrive(float) {}
    void close(std::size_t, Rgb) {}
};

}  // namespace nephele
