// Normal equations of a few unknowns.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace afferent {

template <std::size_t n>
using SmallVector = std::array<double, n>;
template <std::size_t n>
using SmallMatrix = std::array<SmallVector<n>, n>;

// Turns a symmetric matrix, of which the lower half is read, into its Cholesky factor L, L Lᵀ. False: it is
// not positive definite.
template <std::size_t n>
bool factor(SmallMatrix<n>& a) noexcept {
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = a[i][j];
            for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
            if (i == j && !(sum > 0)) return false;
            a[i][j] = i == j ? std::sqrt(sum) : sum / a[j][j];
        }
        for (std::size_t j = i + 1; j < n; ++j) a[i][j] = 0;
    }
    return true;
}

// The x of  L Lᵀ x = b.
template <std::size_t n>
SmallVector<n> solve(const SmallMatrix<n>& l, SmallVector<n> b) noexcept {
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) b[i] -= l[i][k] * b[k];
        b[i] /= l[i][i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) b[i] -= l[k][i] * b[k];
        b[i] /= l[i][i];
    }
    return b;
}

// The inverse of L Lᵀ.
template <std::size_t n>
SmallMatrix<n> inverse(const SmallMatrix<n>& l) noexcept {
    SmallMatrix<n> inverse{};
    for (std::size_t k = 0; k < n; ++k) {
        SmallVector<n> unit{};
        unit[k] = 1;
        const SmallVector<n> column = solve(l, unit);
        for (std::size_t i = 0; i < n; ++i) inverse[i][k] = column[i];
    }
    return inverse;
}

}  // namespace afferent
