// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/embree_faces.h"

#include "scene/watertight.h"

namespace nephele::embree {

void bound_face(const RTCBoundsFunctionArguments* args) {
    const auto& faces = *static_cast<const OwnFaces*>(args->geometryUserPtr);
    const auto corner = [&](unsigned i) { return faces.corner(args->primID, i, args->timeStep); };
    const Vec3f a = corner(0), b = corner(1), c = corner(2);
    const Vec3f lo = min(a, min(b, c)) - Vec3f(faces.slack), hi = max(a, max(b, c)) + Vec3f(faces.slack);
    RTCBounds& out = *args->bounds_o;
    out.lower_x = lo.x, out.lower_y = lo.y, out.lower_z = lo.z;
    out.upper_x = hi.x, out.upper_y = hi.y, out.upper_z = hi.z;
}

void intersect_face(const RTCIntersectFunctionNArguments* args) {
    if (args->valid[0] == 0)
        return;
    const auto& faces = *static_cast<const OwnFaces*>(args->geometryUserPtr);
    const auto& query = *reinterpret_cast<const Query*>(args->context);
    auto& both = *reinterpret_cast<RTCRayHit*>(args->rayhit);
    RTCRay& ray = both.ray;
    RTCHit& hit = both.hit;
    const WatertightRay line({ray.org_x, ray.org_y, ray.org_z}, {ray.dir_x, ray.dir_y, ray.dir_z});
    const auto corner = [&](unsigned i) { return faces.corner_at(args->primID, i, ray.time); };
    const auto met = line.meet(corner(0), corner(1), corner(2));
    if (!met || !(met->t >= ray.tnear && met->t <= ray.tfar))
        return;
    const unsigned instance = query.context.instID[0];
    const Hit found{met->t, instance == RTC_INVALID_GEOMETRY_ID ? args->geomID : instance, args->primID,
                    met->u, met->v};
    if (query.filter != nullptr &&
        !query.filter->accept(found, met->front != (*query.flipped)[found.instance]))
        return;
    ray.tfar = met->t;
    hit.u = met->u, hit.v = met->v;
    hit.primID = args->primID, hit.geomID = args->geomID, hit.instID[0] = instance;
}

}  // namespace nephele::embree
