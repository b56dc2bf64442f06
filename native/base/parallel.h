// SPDX-License-Identifier: GPL-3.0-or-later
// Loops and jobs on all threads of the arena: oneTBB's. ThreadSanitizer does not see into oneTBB's library,
// where threads hand work to each other; in its builds it is told what the library promises, and nothing
// else: what came before a job is seen by its parts, and what they did is seen by what comes after it.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace nephele {

#ifdef __SANITIZE_THREAD__
/// Lives on the caller's stack as long as the job.
class Handover {
  public:
    Handover() { __tsan_release(&out_); }
    Handover(const Handover&) = delete;
    Handover& operator=(const Handover&) = delete;
    ~Handover() { __tsan_acquire(&back_); }

    template <class F>
    void part(const F& f) {
        __tsan_acquire(&out_);
        f();
        __tsan_release(&back_);
    }

  private:
    char out_ = 0, back_ = 0;
};
#else
struct Handover {
    template <class F>
    void part(const F& f) {
        f();
    }
};
#endif

/// f(i) for all i in [begin, end).
template <class Index, class F>
void parallel_for(Index begin, Index end, const F& f) {
    Handover handover;
    tbb::parallel_for(begin, end, [&](Index i) { handover.part([&] { f(i); }); });
}
/// f(range) for parts of [begin, end) of at least about `grain`.
template <class Index, class F>
void parallel_ranges(Index begin, Index end, std::size_t grain, const F& f) {
    Handover handover;
    tbb::parallel_for(tbb::blocked_range<Index>(begin, end, grain),
                      [&](const tbb::blocked_range<Index>& range) { handover.part([&] { f(range); }); });
}
/// f() and g().
template <class F, class G>
void parallel_invoke(const F& f, const G& g) {
    Handover handover;
    tbb::parallel_invoke([&] { handover.part(f); }, [&] { handover.part(g); });
}
/// f(), where it is, or on a thread of the arena.
template <class F>
void execute_in(tbb::task_arena& arena, const F& f) {
    Handover handover;
    arena.execute([&] { handover.part(f); });
}

}  // namespace nephele
