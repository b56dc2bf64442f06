// SPDX-License-Identifier: GPL-3.0-or-later
// Perspective, orthographic and panoramic cameras with a thin lens.
// The camera looks along its local -z, y up; film positions are in pixels, (0, 0) the bottom left corner of
// the frame.
#pragma once

#include <optional>
#include <string>

#include "math/motion.h"
#include "scene/panorama.h"

namespace nephele {

/// Values of a camera, as in addon/description.py.
struct CameraDescription {
    enum class Kind { perspective, orthographic, panoramic };

    std::string name;
    Kind kind = Kind::perspective;
    double world_from_camera[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    std::vector<std::array<double, 16>> motion;  ///< of world_from_camera over the shutter; empty: none
    std::optional<std::array<Transform, 2>> neighbours;  ///< at the frames before and after
    double left = -1, right = 1, bottom = -1,
           top = 1;  ///< full frame at distance 1, in metres (orthographic), or of the panorama's unit square
    Panorama panorama;                           ///< panoramic only
    float clip_start = 0, clip_end = kInfinity;  ///< m along the view axis (panoramic: along the ray)
    float aperture_radius = 0;                   ///< m; 0: pinhole
    int blades = 0;                              ///< 0: round
    float blades_rotation = 0;                   ///< rad
    float aperture_ratio = 1;                    ///< > 1 narrows the lens along the camera's x
    float focus_distance = 1;                    ///< m, likewise
};

class Camera {
  public:
    /// Throws std::invalid_argument naming the camera and the fault. A scale of the camera's object is
    /// ignored.
    explicit Camera(const CameraDescription& description);
    Camera() : Camera(CameraDescription{}) {}

    /// The world-space ray through a film position (pixels of a frame of film_size); lens_u in [0,1)^2 picks
    /// the point on the lens. d has unit length; t_min and t_max are where the ray crosses the clipping
    /// planes. time: of the shutter, in [0, 1]. Where a panorama shows nothing, t_max is below t_min.
    Ray generate(Vec2f film_position, Vec2f lens_u, Vec2f film_size, float time = 0) const;

    bool moves() const { return motion_.moves(); }
    bool perspective() const { return kind_ == CameraDescription::Kind::perspective; }
    bool orthographic() const { return kind_ == CameraDescription::Kind::orthographic; }
    // The rest is as at the frame itself, wherever the camera goes while the shutter is open.
    Vec3f position() const { return world_from_camera_.translation; }
    /// Unit vector along the view axis, world space.
    Vec3f forward() const { return -world_from_camera_.column(2); }
    /// Depth of a point as the Depth pass counts it: along the view axis, for panoramas the distance.
    float depth(Vec3f world_point) const;
    /// World to camera space with z forward (Blender's Camera coordinates and Depth are measured in it).
    Vec3f to_camera(Vec3f world_point) const;
    /// The same of a vector.
    Vec3f to_camera_vector(Vec3f world_vector) const;
    /// Film position of a world-space point, pixels (pinhole); points behind a perspective camera give
    /// nonsense.
    Vec2f project(Vec3f world_point, Vec2f film_size) const {
        return project(world_point, film_size, world_from_camera_);
    }
    /// The same at the frame before (0) or after (1).
    Vec2f project_at_neighbour(Vec3f world_point, Vec2f film_size, std::size_t which) const {
        return project(world_point, film_size, neighbours_ ? (*neighbours_)[which] : world_from_camera_);
    }

  private:
    Vec2f project(Vec3f world_point, Vec2f film_size, const Transform& world_from_camera) const;
    Vec2f sample_lens(Vec2f u) const;
    Ray panoramic_ray(double x, double y, Vec2f lens_u) const;
    Ray placed(const Ray& ray, float time) const;

    CameraDescription::Kind kind_;
    Transform world_from_camera_;  // rotation and translation only
    Motion motion_;                // likewise
    std::optional<std::array<Transform, 2>> neighbours_;
    Panorama panorama_;
    double left_, right_, bottom_, top_;
    float clip_start_, clip_end_, aperture_radius_, blades_rotation_, inverse_aperture_ratio_,
        focus_distance_;
    int blades_;
};

}  // namespace nephele
