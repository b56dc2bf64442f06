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

GuidingField::GuidingField(const Settings& settings, std::size_t memory) : settings_(settings) {
    trees_.emplace_back("volume", memory / 2);
    for (const char* facing : {"minus_x", "plus_x", "minus_y", "plus_y", "minus_z", "plus_z"})
        trees_.emplace_back(facing, memory / (2 * (kFieldParts - 1)));
}

std::size_t GuidingField::regions() const {
    std::size_t sum = 0;
    for (const FieldTree& tree : trees_)
        sum += tree.regions();
    return sum;
}

std::size_t GuidingField::memory() const {
    std::size_t sum = 0;
    for (const FieldTree& tree : trees_)
        sum += tree.memory();
    return sum;
}

void GuidingField::update(std::vector<FieldSample> samples) {
    std::erase_if(samples, [](const FieldSample& s) { return !usable(s); });
    std::sort(samples.begin(), samples.end(), [](const FieldSample& a, const FieldSample& b) {
        return a.part != b.part ? a.part < b.part : a.key < b.key;
    });
    auto first = samples.begin();
    for (int part = 0; part < kFieldParts; ++part) {
        const auto last = std::find_if(
            first, samples.end(), [&](const FieldSample& s) { return static_cast<int>(s.part) != part; });
        trees_[static_cast<std::size_t>(part)].update(settings_, {first, last});
        first = last;
    }
}

void GuidingField::save(std::map<std::string, std::vector<double>>& saved) const {
    for (const FieldTree& tree : trees_)
        tree.save(saved);
}

void GuidingField::restore(const std::map<std::string, std::vector<double>>& saved) {
    GuidingField field(*this);  // what is refused changes nothing
    for (FieldTree& tree : field.trees_)
        tree.restore(saved);
    *this = std::move(field);
}

}  // namespace nephele
