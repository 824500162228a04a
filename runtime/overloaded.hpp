// A visitor of a variant from one callable for each alternative. An alternative that is forgotten does not
// compile.
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
