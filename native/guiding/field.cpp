// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/field.h"

namespace nephele {

namespace {

/// Large depths and squares are bounded where they are added.
bool usable(const VspRecord& r) {
    return std::isfinite(r.probability) && std::isfinite(r.volume_weight) &&
           std::isfinite(r.surface_weight) && std::isfinite(r.light) && std::isfinite(r.cost) &&
           std::isfinite(r.transmittance) && !std::isnan(r.majorant_depth) && !std::isnan(r.volume_square) &&
           !std::isnan(r.surface_square) && !std::isnan(r.both) && std::isfinite(r.extra_work);
}

bool usable(const FieldSample& s) {
    return is_finite(s.p) && is_finite(s.wi) && std::isfinite(s.light) && s.light >= 0 && s.pdf > 0 &&
           std::isfinite(s.pdf) && std::isfinite(s.scattering) && s.scattering >= 0 && s.scatter_pdf >= 0 &&
           std::isfinite(s.scatter_pdf) && std::isfinite(s.guide_pdf) && s.distance > 0 &&
           std::isfinite(s.cost) && usable(s.vsp);
}

}  // namespace

GuidingField::GuidingField(const Settings& settings, std::size_t memory)
    : settings_(settings), volume_("volume", memory / 2), surface_("surface", memory / 2) {}

void GuidingField::update(std::vector<FieldSample> samples) {
    std::erase_if(samples, [](const FieldSample& s) { return !usable(s); });
    std::sort(samples.begin(), samples.end(),
              [](const FieldSample& a, const FieldSample& b) { return a.key < b.key; });
    const auto surface = std::stable_partition(samples.begin(), samples.end(),
                                               [](const FieldSample& s) { return s.in_volume; });
    volume_.update(settings_, {samples.begin(), surface});
    surface_.update(settings_, {surface, samples.end()});
}

void GuidingField::save(std::map<std::string, std::vector<double>>& saved) const {
    volume_.save(saved);
    surface_.save(saved);
}

void GuidingField::restore(const std::map<std::string, std::vector<double>>& saved) {
    GuidingField field(*this);  // what is refused changes nothing
    field.volume_.restore(saved);
    field.surface_.restore(saved);
    *this = std::move(field);
}

}  // namespace nephele
