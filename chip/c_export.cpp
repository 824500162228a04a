#include "afferent/chip/c_export.hpp"

#include <algorithm>
#include <sstream>

namespace afferent {
namespace {

// The smallest of C's types that holds so many bits.
std::uint32_t type_bits(std::uint32_t bits) { return bits <= 8 ? 8 : bits <= 16 ? 16 : bits <= 32 ? 32 : 64; }
std::string signed_type(std::uint32_t bits) { return "int" + std::to_string(type_bits(bits)) + "_t"; }
std::string unsigned_type(std::uint32_t bits) { return "uint" + std::to_string(type_bits(bits)) + "_t"; }

std::string replaced(std::string text, const std::vector<std::pair<std::string, std::string>>& values) {
    for (const auto& [name, value] : values) {
        const std::string mark = "@" + name + "@";
        for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += value.size())
            text.replace(at, mark.size(), value);
    }
    return text;
}

// A name that ends no comment.
std::string in_a_comment(std::string name) {
    for (char& c : name)
        if (c == '*' || c == '/' || c == '\\' || static_cast<unsigned char>(c) < ' ') c = '_';
    return name;
}

constexpr const char* header =
    R"(/* The neurons of the scene "@scene@", as its emulator computes them, to the bit.
 *
 *     afferent_chip chip;
 *     uint16_t fired[AFFERENT_NEURONS];
 *     afferent_reset(&chip);
 *     every AFFERENT_TICK_NS:
 *         uint32_t count = afferent_tick(&chip, fired);      fired[0 .. count - 1]: who has fired
 *         afferent_set_input(&chip, address, input);         counts from the next tick on
 *
 * No heap, no floating point, no recursion; a tick takes the same instructions whatever the neurons do. */
#ifndef AFFERENT_CHIP_H
#define AFFERENT_CHIP_H

#include <stdint.h>

#define AFFERENT_NEURONS @neurons@u
#define AFFERENT_TICK_NS @tick_ns@
/* An input is b = v_r + R I - E_k in the unit of v, signed, of so many bits. */
#define AFFERENT_INPUT_BITS @input_bits@

/* @bytes@ bytes each. */
typedef struct {
    @input_type@ input;
    @u_type@ u;
    @g_type@ g;
    @refractory_type@ refractory; /* ticks that are left */
} afferent_neuron;

typedef struct {
    afferent_neuron neuron[AFFERENT_NEURONS];
} afferent_chip;

/* All neurons as at the beginning of the scene, without a drive. */
void afferent_reset(afferent_chip *chip);

/* Larger and smaller inputs than there are count as the largest and the smallest. */
void afferent_set_input(afferent_chip *chip, uint16_t address, int64_t input);

/* One tick. Writes the addresses of those that fire at its end, in order, and returns how many they are. */
uint32_t afferent_tick(afferent_chip *chip, uint16_t fired[AFFERENT_NEURONS]);

#endif
)";

constexpr const char* source = R"(#include "afferent_chip.h"

/* What is computed with: no product of what a neuron can hold needs more than @product_bits@ bits. */
typedef @wide@ wide;

/* Right shifts of negative numbers keep their sign. */
typedef char afferent_shifts_are_arithmetic[((wide)-3 >> 1) == -2 ? 1 : -1];

/* Neurons that follow each other and have the same constants. */
typedef struct {
    uint32_t end; /* the first address behind them */
    wide one, v_decay, g_decay, conductance;
    wide threshold, reset, lowest, highest, g_jump, g_most;
    uint32_t decay_bits, conductance_bits, refractory;
    wide even; /* 1: shifts round half to even; 0: they round down */
} group;

static const group groups[] = {
    /* end, one, v_decay, g_decay, conductance, threshold, reset, lowest, highest, g_jump, g_most, decay_bits,
       conductance_bits, refractory, even */
@groups@};

@start@
void afferent_reset(afferent_chip *chip) {
    const group *c = groups;
    for (uint32_t i = 0; i < AFFERENT_NEURONS; ++i) {
        afferent_neuron *n = &chip->neuron[i];
        while (i >= c->end) ++c;
        n->input = (@input_type@)c->reset;
        n->u = (@u_type@)@start_u@;
        n->g = 0;
        n->refractory = 0;
    }
}

void afferent_set_input(afferent_chip *chip, uint16_t address, int64_t input) {
    const int64_t most = ((int64_t)1 << (AFFERENT_INPUT_BITS - 1)) - 1;
    if (address >= AFFERENT_NEURONS) return;
    if (input > most) input = most;
    if (input < -most - 1) input = -most - 1;
    chip->neuron[address].input = (@input_type@)input;
}

static wide shifted(wide product, uint32_t bits, wide even) {
    even &= bits != 0;
    return (product + (even << (bits - (uint32_t)even)) - even + ((product >> bits) & even)) >> bits;
}

/* a where the mask is all ones, b where it is 0. */
static wide chosen(wide mask, wide a, wide b) { return b ^ ((a ^ b) & mask); }

uint32_t afferent_tick(afferent_chip *chip, uint16_t fired[AFFERENT_NEURONS]) {
    uint32_t count = 0;
    uint32_t i = 0;
    for (const group *c = groups; i < AFFERENT_NEURONS; ++c) {
        for (; i < c->end; ++i) {
            afferent_neuron *n = &chip->neuron[i];
            wide g = shifted(n->g * c->g_decay, c->decay_bits, c->even);
            wide kept = c->one - shifted(g * c->conductance, c->conductance_bits, c->even);
            const wide waits = -(wide)(n->refractory != 0);
            wide u, fires;
            kept = chosen(-(wide)(kept < 0), 0, kept);
            u = shifted(n->u * kept, c->decay_bits, c->even);
            u = shifted(u * c->v_decay + n->input * (c->one - c->v_decay), c->decay_bits, c->even);
            u = chosen(-(wide)(u < c->lowest), c->lowest, u);
            u = chosen(-(wide)(u > c->highest), c->highest, u);
            u = chosen(waits, n->u, u);
            fires = -(wide)(u >= c->threshold);
            g += c->g_jump & fires;
            g = chosen(-(wide)(g > c->g_most), c->g_most, g);
            n->u = (@u_type@)chosen(fires, c->reset, u);
            n->g = (@g_type@)g;
            n->refractory = (@refractory_type@)chosen(fires, (wide)c->refractory, n->refractory + waits);
            fired[count] = (uint16_t)i;
            count -= (uint32_t)fires;
        }
    }
    return count;
}
)";

constexpr const char* checker =
    R"(/* Compares the neurons with vectors: check vectors.txt. Says where they part first. */
#include <inttypes.h>
#include <stdio.h>

#include "afferent_chip.h"

static afferent_chip chip;
static uint16_t fired[AFFERENT_NEURONS];

typedef struct {
    char kind;
    int64_t tick, u;
    uint32_t address, g, refractory;
} record;

static int failed(const char *text) { return fprintf(stderr, "%s\n", text), 1; }

static int next(FILE *file, record *r) {
    if (fscanf(file, " %c %" SCNd64, &r->kind, &r->tick) != 2) return 0;
    if (r->kind == 'z') return 1;
    if (fscanf(file, "%" SCNu32, &r->address) != 1 || r->address >= AFFERENT_NEURONS) return 0;
    if (r->kind == 'i') return fscanf(file, "%" SCNd64, &r->u) == 1;
    if (r->kind == 's') return fscanf(file, "%" SCNd64 " %" SCNu32 " %" SCNu32, &r->u, &r->g, &r->refractory) == 3;
    return r->kind == 'e';
}

static int differ(const record *r, const char *what, int64_t is, int64_t expected) {
    fprintf(stderr, "tick %" PRId64 ", address %" PRIu32 ": %s is %" PRId64 " and should be %" PRId64
            ": bits 0x%" PRIx64 " differ\n", r->tick, r->address, what, is, expected, (uint64_t)(is ^ expected));
    return 1;
}

int main(int argc, char **argv) {
    uint32_t neurons;
    int64_t ticks, tick, events = 0, states = 0;
    record r;
    FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (!file) return failed("usage: check vectors.txt");
    if (fscanf(file, "afferent-vectors 1 %" SCNu32 " %" SCNd64, &neurons, &ticks) != 2 || neurons != AFFERENT_NEURONS)
        return failed("these are no vectors of this chip");
    if (!next(file, &r)) return failed("a record cannot be read");
    afferent_reset(&chip);
    for (tick = 1; tick <= ticks; ++tick) {
        uint32_t count, i;
        for (; r.tick == tick && r.kind == 'i';) {
            afferent_set_input(&chip, (uint16_t)r.address, r.u);
            if (!next(file, &r)) return failed("a record cannot be read");
        }
        count = afferent_tick(&chip, fired);
        for (i = 0; i < count; ++i, ++events) {
            if (r.tick != tick || r.kind != 'e' || r.address > fired[i]) {
                r.tick = tick, r.address = fired[i];
                return differ(&r, "the number of its spikes", 1, 0);
            }
            if (r.address < fired[i]) return differ(&r, "the number of its spikes", 0, 1);
            if (!next(file, &r)) return failed("a record cannot be read");
        }
        if (r.tick == tick && r.kind == 'e') return differ(&r, "the number of its spikes", 0, 1);
        for (; r.tick == tick && r.kind == 's'; ++states) {
            const afferent_neuron *n = &chip.neuron[r.address];
            if (n->u != r.u) return differ(&r, "u", n->u, r.u);
            if (n->g != r.g) return differ(&r, "g", n->g, r.g);
            if (n->refractory != r.refractory) return differ(&r, "refractory", n->refractory, r.refractory);
            if (!next(file, &r)) return failed("a record cannot be read");
        }
        if (r.tick <= tick) return failed("the records are not in order");
    }
    if (r.kind != 'z') return failed("the records do not end");
    printf("%" PRIu32 " neurons, %" PRId64 " ticks, %" PRId64 " events, %" PRId64 " states: equal\n", neurons, ticks,
           events, states);
    return 0;
}
)";

constexpr const char* makefile = R"(# make test: checks the neurons against their vectors on this machine.
CFLAGS = -std=c99 -O2 -Wall -Wextra -pedantic

test: check
	./check vectors.txt

check: check.c afferent_chip.c afferent_chip.h
	$(CC) $(CFLAGS) -o $@ check.c afferent_chip.c

clean:
	rm -f check
.PHONY: test clean
)";

constexpr const char* readme = R"(# The neurons of the scene "@scene@"

@neurons@ neurons on ticks of @tick_us@ µs, @bytes@ bytes of RAM each, in C99 that needs nothing but `<stdint.h>`. They are equal to
those of Afferent's emulator, to the bit: `make test` compares them with `vectors.txt` on this machine.

| file | what it is |
|---|---|
| `afferent_chip.h` | how to use them: four lines in its comment |
| `afferent_chip.c` | the arithmetic, and the constants of each neuron |
| `vectors.txt` | inputs, and the events and states that have to follow |
| `check.c` | reads the vectors; says the first tick, address and bit that differ |

For firmware, compile `afferent_chip.c` beside your own. It never allocates and has no branch that depends on
a neuron's state, so that a tick takes the same time whatever happens. Products have @product_bits@ bits at most, whatever the
neurons are given.

An implementation of your own reads `vectors.txt`: after a line `afferent-vectors 1 NEURONS TICKS`, one record on a line, in the
order of ticks, of which the first is 1:

    i TICK ADDRESS INPUT              from this tick on, this neuron has this input; before it, the input of no drive
    e TICK ADDRESS                    it fires at the end of this tick; where there is no such line, it does not
    s TICK ADDRESS U G REFRACTORY     its state after this tick, and after it has fired
    z TICKS+1                         the end
)";

std::string group_rows(const ChipNeurons& neurons) {
    std::ostringstream rows;
    for (const ChipNeurons::Group& group : neurons.groups) {
        const FixedPointLif::Codes& c = group.neuron.codes();
        rows << "    {" << group.begin + group.count << ", " << c.one << ", " << c.v_decay << ", "
             << c.g_decay << ", " << c.conductance << ", " << c.threshold << ", " << c.reset << ", "
             << c.lowest << ", " << c.highest << ", " << c.g_jump << ", " << c.g_most << ", " << c.decay_bits
             << ", " << c.conductance_bits << ", " << c.refractory_ticks << "u, "
             << (c.rounding == Rounding::half_even) << "},\n";
    }
    return rows.str();
}

// Where neurons begin at different phases.
std::string start_table(const ChipNeurons& neurons, const std::string& type) {
    std::string table = "static const " + type + " start[AFFERENT_NEURONS] = {";
    for (Address i = 0; i < neurons.count(); ++i)
        table += (i % 16 == 0 ? "\n    " : " ") + std::to_string(neurons.start[i].u) + ",";
    return table + "\n};\n";
}

bool begins_at_rest(const ChipNeurons& neurons) {
    for (Address i = 0; i < neurons.count(); ++i)
        if (neurons.start[i].u != neurons.neuron(i).codes().reset) return false;
    return true;
}

}  // namespace

std::uint32_t exported_bytes_per_neuron(const ChipNeurons& neurons) {
    const ChipWidths widths = chip_widths(neurons);
    std::uint32_t bytes = 0;
    std::uint32_t aligned = 1;
    for (const std::uint32_t bits :
         {widths.input_bits, widths.u_bits, widths.g_bits, widths.refractory_bits}) {
        const std::uint32_t size = type_bits(bits) / 8;
        aligned = std::max(aligned, size);
        bytes = (bytes + size - 1) / size * size + size;
    }
    return (bytes + aligned - 1) / aligned * aligned;
}

std::vector<ExportedFile> export_c(const ChipNeurons& neurons, const std::string& scene) {
    const ChipWidths widths = chip_widths(neurons);
    const std::string u_type = signed_type(widths.u_bits);
    const bool at_rest = begins_at_rest(neurons);
    const std::vector<std::pair<std::string, std::string>> values{
        {"scene", in_a_comment(scene)},
        {"neurons", std::to_string(neurons.count())},
        {"tick_ns", std::to_string(neurons.tick_ns)},
        {"tick_us", std::to_string(neurons.tick_ns / 1000)},
        {"input_bits", std::to_string(widths.input_bits)},
        {"input_type", signed_type(widths.input_bits)},
        {"u_type", u_type},
        {"g_type", unsigned_type(widths.g_bits)},
        {"refractory_type", unsigned_type(widths.refractory_bits)},
        {"wide", signed_type(std::max(widths.product_bits, 32U))},
        {"product_bits", std::to_string(widths.product_bits)},
        {"bytes", std::to_string(exported_bytes_per_neuron(neurons))},
        {"groups", group_rows(neurons)},
        {"start", at_rest ? "" : start_table(neurons, u_type)},
        {"start_u", at_rest ? "c->reset" : "start[i]"}};
    return {{"afferent_chip.h", replaced(header, values)},
            {"afferent_chip.c", replaced(source, values)},
            {"check.c", checker},
            {"Makefile", makefile},
            {"README.md", replaced(readme, values)}};
}

}  // namespace afferent
