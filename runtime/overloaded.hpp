// A visitor of variants made of one callable per alternative; a missing one does not compile. Included by
// programs that visit the variants of a scene.
#pragma once

namespace afferent {

//     std::visit(Overloaded{[](const Tcp& tcp) { ... }, [](const Udp& udp) { ... }}, transport);
template <class... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

}  // namespace afferent
