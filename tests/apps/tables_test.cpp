// Tables as they come, through the program: inspected, run, and refused.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using TableJson = nlohmann::json;

// Six force-sensing resistors in volts at 250 Hz, with semicolons and decimal commas, from 1000 s on.
std::string six_resistors() {
    std::string text = "# from the desk\nZeit [ms];FSR1 [V];FSR2 [V];FSR3 [V];FSR4 [V];FSR5 [V];FSR6 [V]\n";
    for (int row = 0; row < 1000; ++row) {
        text += std::to_string(1'000'000 + 4 * row);
        for (int i = 0; i < 6; ++i) {
            const double press = std::max(0.0, std::sin((row - 150) / 700.0 * 3.14159)) * (row < 850 ? 1 : 0);
            const double ohm = press > 0.001 ? 6000 / std::pow(press * (1 + 0.5 * i), 0.8) : 1e7;
            char volts[16];
            std::snprintf(volts, sizeof volts, "%.4f", 5 * 1e4 / (1e4 + ohm));
            std::string field = volts;
            field.replace(field.find('.'), 1, ",");
            text += ";" + field;
        }
        text += '\n';
    }
    return text;
}

class TablesAsTheyCome : public testing::Test {
  protected:
    TableJson run(std::vector<std::string> arguments) {
        arguments.emplace_back("--json");
        Process process(std::move(arguments));
        EXPECT_EQ(process.wait(), 0) << process.err();
        return TableJson::parse(process.out(), nullptr, false);
    }
    std::string refusal(std::vector<std::string> arguments) {
        Process process(std::move(arguments));
        EXPECT_GT(process.wait(), 0);
        return process.err();
    }
    static void expect(const std::string& said, const std::string& text) {
        EXPECT_NE(said.find(text), std::string::npos) << said;
    }
    const Folder folder_;
};

TEST_F(TablesAsTheyCome, RunInTwoCommandsWithoutAScene) {
    write_file(folder_ / "six.csv", six_resistors());
    const TableJson found =
        run({"inspect", folder_("six.csv"), "--scene", folder_("six.txtpb"), "--out", folder_("look")});
    EXPECT_EQ(found.at("rows"), 1000);
    EXPECT_EQ(found.at("rate_hz"), 250);
    EXPECT_EQ(found.at("gaps"), 0);
    EXPECT_EQ(found.at("columns").size(), 6U);
    EXPECT_EQ(found.at("columns").at(5).at("taken_for"), "force");
    EXPECT_EQ(found.at("columns").at(5).at("unit"), "volts");
    EXPECT_EQ(found.at("assumed").size(), 1U);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "look/inspection.json"));
    const TableJson summary = run({"run", folder_("six.txtpb"), "--out", folder_("out")});
    EXPECT_EQ(summary.at("duration_s"), 4) << "the table's";
    EXPECT_GT(summary.at("events"), 300);
    EXPECT_LT(summary.at("force_error_rms_n").get<double>(), 1) << "of up to 10 N";
    EXPECT_EQ(summary.at("notes").at(0), "Forces: the table's time 1000 s is the scene's 0");
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out/events.csv"));
    // It has a link, so that it is recorded, too.
    run({"run", folder_("six.txtpb"), "--record", folder_("six.afferent")});
    EXPECT_EQ(run({"replay", folder_("six.afferent"), "--fast"})["force_error_rms_n"],
              summary.at("force_error_rms_n"));
    // For people, too.
    Process people({"inspect", folder_("six.csv")});
    EXPECT_EQ(people.wait(), 0) << people.err();
    for (const char* text : {"Semicolons separate its columns.", "The decimal mark is a comma", "FSR6 [V]",
                             "Assumed: ", "source {", "--scene FILE writes it"})
        expect(people.out(), text);
}

TEST_F(TablesAsTheyCome, AreReadCompressedAndFromStandardInput) {
    const std::string table = "t_ms;F [mN]\n0;0\n5;500\n10;2500\n15;3000\n500;3000\n";
    write_file(folder_ / "f.csv", table);
    const TableJson plain = run({"run", examples + "grasp.txtpb", "--table", folder_("f.csv")});
    ASSERT_EQ(std::system(("gzip -kn " + folder_("f.csv")).c_str()), 0);
    const TableJson compressed = run({"run", examples + "grasp.txtpb", "--table", folder_("f.csv.gz")});
    EXPECT_EQ(plain.at("events"), compressed.at("events"));
    EXPECT_GT(plain.at("events"), 0);
    write_file(folder_ / "s.txtpb", "duration_s: 1 source { standard_input {} }");
    Process piped({"run", folder_("s.txtpb"), "--json"}, table);
    ASSERT_EQ(piped.wait(), 0) << piped.err();
    EXPECT_GT(TableJson::parse(piped.out())["events"], 0);
    Process gzipped({"run", folder_("s.txtpb")}, read_file(folder_ / "f.csv.gz"));
    EXPECT_GT(gzipped.wait(), 0);
    expect(gzipped.err(), "through zcat");
}

TEST_F(TablesAsTheyCome, ThatDoNotFitTheirSceneAreToldSo) {
    write_file(folder_ / "f.csv", "time_s,force_n\n0,1\n0.5,3\n");
    write_file(folder_ / "e.csv", "time_s,emg_mv\n0,0.1\n0.1,0.2\n0.2,0.1\n");
    write_file(folder_ / "s.txtpb", "duration_s: 2 source { table { path: 'f.csv' } }");
    const TableJson alone = run({"run", folder_("s.txtpb")});
    ASSERT_EQ(alone.at("notes").size(), 2U);
    EXPECT_EQ(alone.at("notes").at(0),
              "Forces: the table ends at 0.5 s, the scene at 2 s; the last forces are held until then");
    EXPECT_EQ(alone.at("notes").at(1),
              "EMG: none beside the recorded force, so both muscles rest (--emg names a table)");
    write_file(folder_ / "s.txtpb",
               "duration_s: 2 source { table { path: 'f.csv' } } hand { emg_table { path: 'e.csv' column: "
               "'emg_mv' } }");
    const TableJson both = run({"run", folder_("s.txtpb")});
    ASSERT_EQ(both.at("notes").size(), 3U);
    expect(both.at("notes").at(1), "EMG: column \"emg_mv\" is in volts, an envelope");
    EXPECT_EQ(both.at("notes").at(2), "EMG: the table ends at 0.2 s, and the muscle rests from then on");
    Process people({"run", folder_("s.txtpb")});
    EXPECT_EQ(people.wait(), 0);
    expect(people.out(), "notes");
    expect(people.out(), "                              EMG: the table ends at 0.2 s");
}

// At rest half of the time, which is no reason to say anything.
TEST_F(TablesAsTheyCome, WhoseSamplesAreMostlyOutOfRangeAreToldSo) {
    const auto notes = [&](const std::string& force) {
        write_file(folder_ / "f.csv", "time_s,force_n\n0,0\n0.6,0\n0.601," + force + "\n1," + force + "\n");
        write_file(folder_ / "s.txtpb",
                   "duration_s: 1 every_patch { sensor { full_scale_n: 5 } } source { table { path: 'f.csv' "
                   "between: HOLD } }");
        return run({"run", folder_("s.txtpb")})["notes"].dump();
    };
    EXPECT_EQ(notes("4").find("samples are"), std::string::npos);
    expect(notes("-4"), " samples are below 0, and read as 0: is the sign reversed, or the zero wrong?");
    expect(notes("4000"), " samples are beyond full scale, and read as that: is sensor { full_scale_n }");
}

TEST_F(TablesAsTheyCome, WithoutANewlineAtTheirEndAreToldSo) {
    write_file(folder_ / "f.csv", "time_s,force_n\n0,1\n0.5,3\n1,3.2");
    write_file(folder_ / "e.csv", "time_s,emg_mv\n0,0.1\n0.1,0.2\n0.2,0.1\n0.9,0");
    write_file(folder_ / "s.txtpb",
               "duration_s: 2 source { table { path: 'f.csv' } } hand { emg_table { path: 'e.csv' column: "
               "'emg_mv' } }");
    const std::string notes = run({"run", folder_("s.txtpb")})["notes"].dump();
    expect(notes, "Forces: The last line, 4, has no newline and may be cut off: it is left out");
    expect(notes, "EMG: The last line, 5, has no newline");
    Process inspect({"inspect", folder_("f.csv")});
    EXPECT_EQ(inspect.wait(), 0) << inspect.err();
    expect(inspect.out(), "The last line, 4, has no newline and may be cut off: it is left out.");
}

TEST_F(TablesAsTheyCome, TakeOptionsForWhatCannotBeFound) {
    write_file(folder_ / "f.csv", "t,a,b\n0,1,2\n4,2,3\n8,3,4\n");
    const std::string file = folder_("f.csv");
    expect(refusal({"inspect", file}),
           "f.csv:3: column \"t\": no unit is said, and a step of 4 may be of milliseconds");
    expect(refusal({"inspect", file, "--time-unit", "ms"}), "no scene: no column is known to be a force");
    const TableJson found = run({"inspect", file, "--time-unit", "ms", "--unit", "newtons", "--columns", "b",
                                 "--scene", folder_("s.txtpb")});
    EXPECT_EQ(found.at("rate_hz"), 250);
    EXPECT_EQ(run({"run", folder_("s.txtpb")})["samples"], 3);
    EXPECT_EQ(run({"run", examples + "grasp.txtpb", "--table", file, "--columns", "a", "--unit", "newtons",
                   "--rate-hz", "100"})["samples"],
              45);
    expect(refusal({"inspect", file, "--time-unit", "hours"}),
           "--time-unit: must be one of s, ms, us, ns, min, date");
    expect(refusal({"inspect", file, "--calibration", "1:2"}),
           "--calibration: must be points such as 0:0,1.2:0.5,3:4");
    expect(refusal({"inspect", file, "--calibration", "1:0,1:2"}), "in rising order");
    expect(refusal({"run", examples + "grasp.txtpb", "--columns", "a"}),
           "the scene reads none; name one by --table");
    expect(refusal({"inspect", folder_("none.csv")}), "none.csv: cannot be read: No such file or directory");
}

// A header of NumPy's format, version 1.
std::string npy(const std::string& header, const std::string& data = "") {
    std::string text("\x93NUMPY\x01\x00", 8);
    text += static_cast<char>(header.size() & 0xFFU);
    text += static_cast<char>(header.size() >> 8U);
    return text + header + data;
}

TEST_F(TablesAsTheyCome, OfHostileArraysAreRefusedSoon) {
    const std::string file = folder_("a.npy");
    const auto said = [&](const std::string& content) {
        write_file(file, content);
        return refusal({"inspect", file, "--rate-hz", "100", "--unit", "newtons"});
    };
    expect(said(""), "is not in NumPy's format");
    expect(said(npy("{'descr': '|O', 'fortran_order': False, 'shape': (3,), }")), "is of Python's objects");
    expect(said(npy("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (3,), }")),
           "is of structures");
    expect(said(npy("{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }", "12345678")), "is cut off");
    expect(said(npy("{'descr': '<f8', 'fortran_order': False, 'shape': (100000000, 100000000), }")),
           "has neither one dimension nor two");
    expect(said(npy("{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999999999999999,), }")),
           "too large a shape");
    expect(said(npy("{'descr': '<f8', 'fortran_order': False, 'shape': (100000000,), }")), "is cut off");
    expect(said(npy("{'descr': '<U8', 'fortran_order': False, 'shape': (3,), }")), "which is not read");
    expect(said(npy("x")), "has no header that can be read");
    expect(said(npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }",
                    std::string(15, '\xFF') + '\x7F')),
           "2 values are missing in 2 rows");
    write_file(folder_ / "a.npz", "PK\x05\x06 and nothing else");
    expect(refusal({"inspect", folder_("a.npz")}), "is not an archive in the format of NPZ");
    // It is read where it is good.
    const std::string one("\0\0\0\0\0\0\xF0\x3F", 8);
    write_file(file, npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", one + one));
    EXPECT_EQ(run({"inspect", file, "--rate-hz", "100", "--unit", "newtons"})["columns"][0]["highest"], 1);
}

}  // namespace
}  // namespace afferent
