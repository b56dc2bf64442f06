// SPDX-License-Identifier: GPL-3.0-or-later
// The scene: immutable once built. `SceneSource` is what the bindings read from the description; `Scene` adds
// what rendering needs: ray tracing hierarchies, grids with their majorants, light distributions.
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "film/sample_parts.h"
#include "grids/vdb_file.h"
#include "lights/light_set.h"
#include "media/medium.h"
#include "media/segment.h"
#include "scene/camera.h"
#include "scene/intersector.h"
#include "scene/mesh.h"
#include "settings_table.h"
#include "surfaces/bsdf.h"

namespace nephele {

/// One volume shader, as description.VolumeClosure has it.
struct VolumeClosure {
    Rgb sigma_s, sigma_a, emission;
    PhaseFunction phase;
    std::string density_grid;        ///< scales sigma_s and sigma_a; empty: 1 everywhere
    std::string emission_grid;       ///< scales emission; empty: 1 everywhere. At most one of the two is set
    std::optional<Program> program;  ///< run at each point in place of all the above
    std::vector<std::string> grids;  ///< that the program reads, by number
    bool program_has_phase = true;   ///< else `phase` stands

    const std::string& grid() const { return density_grid.empty() ? emission_grid : density_grid; }
};

struct Material {
    std::string name;
    std::optional<Program> surface;  ///< none: a pure volume boundary
    std::vector<VolumeClosure> volume;
    float pass_index = 0;
    std::uint32_t matte = 0;  ///< see film/matte.h
};

/// A VDB file placed in the world.
struct VolumeSource {
    std::string name, path;
    double world_from_object[16];
    Motion motion;  ///< of world_from_object over the shutter
    std::uint32_t material = 0;
    float density_scale = 1;
    std::uint32_t visibility = ~0u;
    GridOptions options;
    std::vector<std::string> velocity_grids;  ///< one of vectors or three of numbers; empty: no motion blur
    float velocity_scale = 0;  ///< m of the file's space per frame that a value of 1 stands for
    Vec3f generated_min{-1}, generated_size{2};  ///< box of generated coordinates, file's space
    float random = 0, pass_index = 0;
    std::array<float, 4> color{1, 1, 1, 1};
    std::uint8_t receiver_set = 0, blocker_set = 0;  ///< see Linking
};

struct WorldSource {
    std::optional<Program> background;
    std::vector<VolumeClosure> volume;
    std::uint32_t visibility = ~0u;
};

struct SceneSource {
    CameraDescription camera;
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<VolumeSource> volumes;
    std::vector<Material> materials;
    std::vector<Image> images;
    std::vector<LampDescription> lamps;
    WorldSource world;
    float pixel_width = 0.001f;                 ///< on the viewplane
    std::array<double, 3> origin{};             ///< of the world here, in the description's world
    float shutter_open = 0, shutter_close = 0;  ///< frames from this one
    std::vector<float>
        shutter_curve;  ///< times in [0, 1] that divide the light into equal parts; empty: even
};

/// What a scene holds, decided once: the integrator is specialised by it.
struct SceneFeatures {
    bool media = false;       ///< any region with a medium
    bool grids = false;       ///< any medium scaled by a grid
    bool programs = false;    ///< any medium whose coefficients a program computes
    bool mesh_media = false;  ///< any medium bounded by a mesh
    bool overlap = false;     ///< more than one medium
    bool chromatic = false;   ///< sigma_t differs between channels
    bool volume_emission = false;
    bool surfaces = false;
    bool transparent_surfaces = false;  ///< shadow rays may pass surfaces
    bool hidden_surfaces = false;       ///< some surface is not visible to some rays
    bool nested_dielectrics = false;    ///< some object has a dielectric priority
    bool lamps = false;
    bool mesh_lights = false;
    bool background = false;
    bool camera_lamps = false;    ///< the camera sees some lamp
    bool lamp_shaders = false;    ///< node trees tint some lamp
    bool light_linking = false;   ///< some light does not shine on everything
    bool shadow_linking = false;  ///< some light shines through something
    bool holdouts = false;        ///< some object is a hole in the picture
    bool motion = false;          ///< something moves while the shutter is open: paths have a time

    /// Names of the features that are there (present) or left out.
    std::vector<std::string> list(bool present) const;
};

/// A volume object as programs see it, and what carries its regions where it moves.
struct VolumeObject {
    Instance instance;
    Mesh mesh;  ///< without triangles: the box of generated coordinates
};

/// A lamp as its node tree sees it.
struct LampShader {
    Program program;
    Instance instance;
    Mesh mesh;  ///< one triangle, whose barycentric coordinates are texture coordinates
};

/// A grid that was loaded, for statistics.
struct GridUse {
    std::string volume, path, grid;
    std::size_t active_voxels = 0, bytes = 0;
};

class Scene {
  public:
    /// Builds everything. Throws std::runtime_error or std::invalid_argument naming the object or file at
    /// fault.
    /// parts: of earlier scenes. What is among them is not built again, and in the end it holds this scene's.
    explicit Scene(SceneSource source, const Settings& settings = {}, PartCache* parts = nullptr);

    const SceneFeatures& features() const { return features_; }
    const Camera& camera() const { return *camera_; }
    const LightSet& lights() const { return lights_; }
    const std::vector<std::string>& warnings() const { return warnings_; }
    const std::vector<GridUse>& grids() const { return grids_; }
    std::size_t hierarchy_bytes() const;

    /// Nearest surface in the ray that rays of this kind see.
    Hit intersect(const Ray& ray, std::uint32_t ray_kind) const;
    /// Nearest face of one instance, whichever side it shows: where what scatters below its surface comes
    /// out.
    Hit intersect_within(const Ray& ray, std::uint32_t instance) const;
    /// Light that the surfaces along the ray let through; 0 where an opaque one is in the way. blockers: see
    /// Linking.
    Rgb surface_transmittance(const Ray& ray, std::uint64_t blockers = Linking::kAll) const;
    /// The media along the ray.
    void find_media(const Ray& ray, std::uint32_t ray_kind, Segment& out,
                    std::uint64_t blockers = Linking::kAll) const;
    /// Of the object whose medium is at t of a segment that find_media made; 0 where none is.
    std::uint8_t receiver_set_at(const Segment& segment, float t) const;

    ShadingPoint shading_point(const Hit& hit, const Ray& ray, std::uint32_t ray_kind) const;
    /// Where a ray leaves a surface: the vertex of the path, and the ray's origin a little off the surface.
    struct Departure {
        Vec3f vertex, o;
    };
    /// Where a ray along wi leaves the surface at `point`, on wo's side or, where it `crosses`, on the other.
    Departure departure(const ShadingPoint& point, Vec3f wi, bool crosses) const;
    const Program* program_of(const ShadingPoint& point) const;
    /// Pass index of the material at a point, and the ids of all that covers so much of a pixel there.
    float material_index(const ShadingPoint& point) const;
    /// Where the surface at a point was in the picture at the frame before, less where it is, and that less
    /// where it will be at the next frame; pixels.
    std::array<float, 4> motion_vector(const ShadingPoint& point, Vec2f film_size) const;
    Matte matte(const ShadingPoint& point, float weight) const;
    const TextureContext& textures() const { return textures_; }
    /// Radiance of the background seen in direction d by rays of this kind.
    Rgb background(Vec3f d, std::uint32_t ray_kind, const RayHistory& history = {}) const;
    /// What a lamp's node tree makes of its radiance along the ray, which meets it at `distance`.
    Rgb lamp_tint(std::uint32_t lamp, const Ray& ray, float distance, std::uint32_t ray_kind,
                  const RayHistory& history) const;
    /// The time of the shutter that a random number in [0, 1) stands for.
    float shutter_time(float u) const;
    std::uint32_t world_visibility() const { return source_.world.visibility; }
    static constexpr std::uint32_t kNoLight = ~0u;
    /// Number of the light that an instance's emissive triangles are, or kNoLight.
    std::uint32_t light_of_instance(std::uint32_t instance) const {
        return mesh_light_of_instance_[instance];
    }
    /// Number of an instance of this scene.
    std::uint32_t number_of(const Instance& instance) const {
        return static_cast<std::uint32_t>(&instance - source_.instances.data());
    }

  private:
    struct SurfaceFilter;
    struct InstanceFilter;
    struct TransmittanceFilter;
    std::int32_t material_of(const Hit& hit) const;
    Rgb transparency(const Hit& hit, const Ray& ray) const;
    // scene_nesting.cpp
    float interior_ior(const Crossing& wall, const Ray& ray, std::uint32_t ray_kind) const;
    Hit nearest_interface(const Ray& ray, std::uint32_t ray_kind, const Hit& hit) const;
    Rgb interface_transmittance(const Ray& ray) const;
    void drop_priority_of_emitter(Instance& instance);
    /// Whether the triangle has a surface shader that rays of this kind see.
    bool is_surface(const Hit& hit, std::uint32_t ray_kind) const;
    std::vector<float> check_meshes();
    void add_meshes();
    void add_lights_of_meshes(std::vector<MeshLight>& lights, std::size_t lamps);
    void add_volumes();
    void add_lights();
    void add_lamp_shader(const LampDescription& lamp);
    // scene_media.cpp
    Medium constant_medium(const VolumeClosure& closure, float scale) const;
    Medium program_medium(const VolumeClosure& closure, float scale, VolumeFields fields,
                          const ShadingPoint& place, const BoundsFrame& frame);
    BoundsOptions bounds_options() const;
    std::span<const ImageBounds> image_bounds();
    /// Adds a region with its media; those that vary and scatter alike become one.
    void add_region(Region region, std::vector<Medium> media);
    void add_mesh_region(const Instance& instance, const std::vector<VolumeClosure>& closures);
    void add_world_region();
    // scene_volumes.cpp
    class VolumeBuilder;
    void decide_features();

    PartScope* parts_ = nullptr;  ///< while it is built
    SceneSource source_;
    Settings settings_;
    std::vector<ProgramTraits> traits_;  ///< by material; the last entry is the default's
    std::vector<Medium> media_;
    std::vector<Region> regions_;
    std::vector<std::uint32_t> region_of_instance_;  ///< of mesh regions; ~0 elsewhere
    std::vector<std::uint32_t> mesh_light_of_instance_;
    std::shared_ptr<const Intersector> surfaces_;     ///< all but objects with a dielectric priority
    std::shared_ptr<const Intersector> boundaries_;   ///< meshes that bound media
    std::shared_ptr<const Intersector> dielectrics_;  ///< objects with a dielectric priority
    std::optional<Camera> camera_;
    LightSet lights_;
    std::vector<std::shared_ptr<const LampShader>> lamp_shaders_;  ///< by lamp; null: none
    TextureContext textures_;
    std::vector<ImageBounds> image_bounds_;  ///< made when a volume's program asks first
    std::deque<VolumeObject>
        volume_objects_;  ///< one for each volume, in order; regions and media hold on to them
    SceneFeatures features_;
    std::vector<std::string> warnings_;
    std::vector<GridUse> grids_;
};

}  // namespace nephele
