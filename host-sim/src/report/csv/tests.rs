use super::*;
use crate::report::record::Source;
use model_core::protocol::{LinkMode, Telemetry, outputs_of};
use model_core::supervisor::fault::FaultSet;
use proptest::prelude::*;

/// Telemetry in which no two numbers are the same.
fn telemetry(tick: u32) -> Telemetry {
    Telemetry {
        tick,
        mode: LinkMode::Faulted(4),
        faults: 1 << 4 | 1 << 42 | 1 << 63,
        priority: 3,
        setpoints: [60 << 16, 30 << 16, 15 << 16],
        estimates: [59 << 16, 29 << 16, 14 << 16],
        manifold: None,
        bend: Some(123 << 16),
        outputs: outputs_of(&model_core::actuation::Actuation::HOLD),
        step: 7,
        repeat: 2,
        holding: true,
        fingertip_um: [101_500, -20_250],
        fingertip_millideg: 90_125,
        force_mn: 5_500,
        overruns: 11,
        dropped_frames: 12,
        tick_cycles: 3_586,
        worst_tick_cycles: 7_077,
    }
}

fn device_row(time_ms: u32) -> Record {
    let mut record = Record::from_telemetry(Source::Device, time_ms, &telemetry(time_ms + 5));
    record.unix_ms = Some(1_800_000_000_000 + u64::from(time_ms));
    record.link.frames_lost = Some(3);
    record.link.frames_bad = Some(4);
    record.event = "nack: NotVented".into();
    record
}

fn written(records: &[Record]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = RecordWriter::new(&mut bytes, 7).expect("memory");
    for record in records {
        writer.write(record).expect("memory");
    }
    drop(writer);
    bytes
}

/// Rows compare by their text: not-a-number is no equal of itself.
fn texts(records: &[Record]) -> Vec<String> {
    records.iter().map(row).collect()
}

#[test]
fn what_a_device_said_stands_under_the_columns_names() {
    let bytes = written(&[device_row(10)]);
    let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
    let header = reader.headers().expect("a header").clone();
    let row = reader.records().next().expect("a row").expect("a row");
    for (column, expected) in [
        ("schema", "2"),
        ("source", "device"),
        ("time_ms", "10"),
        ("unix_ms", "1800000000010"),
        ("device_ms", "15"),
        ("mode", "faulted:emergency-stop"),
        ("faults", "emergency-stop|leak-slow|code-63"),
        ("priority", "high"),
        ("repeat", "2"),
        ("step", "7"),
        ("holding", "1"),
        ("pump_on", "0"),
        ("dump_open", "0"),
        ("valve_distal_open", "0"),
        ("setpoint_proximal_kpa", "60.0000"),
        ("setpoint_distal_kpa", "15.0000"),
        ("estimate_middle_kpa", "29.0000"),
        ("chamber_proximal_kpa", ""),
        ("manifold_kpa", ""),
        ("sensor_kpa", ""),
        ("bend_proximal_deg", ""),
        ("bend_finger_deg", ""),
        ("bend_sensor_deg", "123.0000"),
        ("model_bend_middle_deg", ""),
        ("fingertip_x_mm", "101.5000"),
        ("fingertip_y_mm", "-20.2500"),
        ("fingertip_deg", "90.1250"),
        ("force_n", "5.5000"),
        ("late_ticks", "11"),
        ("device_dropped_frames", "12"),
        ("tick_cycles", "3586"),
        ("worst_tick_cycles", "7077"),
        ("frames_lost", "3"),
        ("frames_bad", "4"),
        ("event", "nack: NotVented"),
    ] {
        let place = header.iter().position(|name| name == column).expect(column);
        assert_eq!(&row[place], expected, "{column}");
    }
}

#[test]
fn rows_read_back_as_they_were_written() {
    let mut records: Vec<Record> = (1..40).map(|index| device_row(index * 10)).collect();
    records[3].model_bends_deg = [1.5, 2.5, 3.5];
    records[4].bends_deg = [10.0, 20.0, 30.0];
    records[5] = Record::unknown(Source::Emulated, 60);
    let recording = read(&written(&records)).expect("a recording");
    assert_eq!(texts(&recording.records), texts(&records));
    assert_eq!((recording.schema, recording.torn, recording.bad_lines), (SCHEMA, false, 0));
    assert_eq!(recording.records[0].faults, FaultSet::from_bits(telemetry(0).faults));
    assert_eq!(recording.records[4].bends_deg[1].to_bits(), 20.0_f64.to_bits());
}

#[test]
fn a_file_cut_at_any_byte_gives_its_whole_rows() {
    let records: Vec<Record> = (1..=5).map(|index| device_row(index * 10)).collect();
    let bytes = written(&records);
    let ends: Vec<usize> = (0..bytes.len()).filter(|&index| bytes[index] == b'\n').map(|index| index + 1).collect();
    for cut in 0..=bytes.len() {
        let whole = ends.iter().filter(|&&end| end <= cut).count().saturating_sub(1);
        match read(&bytes[..cut]) {
            Ok(recording) => {
                assert_eq!(texts(&recording.records), texts(&records[..whole]), "cut at {cut}");
                assert_eq!(recording.torn, !ends.contains(&cut), "cut at {cut}");
                assert_eq!(recording.bad_lines, 0, "cut at {cut}");
            }
            Err(_) => assert_eq!(whole, 0, "cut at {cut}"),
        }
    }
}

#[test]
fn damaged_lines_are_counted_and_the_first_is_named() {
    let mut text = String::from_utf8(written(&[device_row(10), device_row(20), device_row(30)])).expect("text");
    let again = row(&device_row(20));
    text += &again;
    text += "2,device,4";
    text += &row(&device_row(40)).replace("faulted:emergency-stop", "dancing");
    text += &"\0".repeat(100);
    text += "\n";
    text += &row(&device_row(50));
    let recording = read(text.as_bytes()).expect("a recording");
    assert_eq!(recording.records.iter().map(|record| record.time_ms).collect::<Vec<_>>(), [10, 20, 30, 50]);
    assert_eq!(recording.bad_lines, 3);
    let (line, why) = recording.first_bad.expect("named");
    assert!(line == 5 && why.contains("time_ms 20"), "line {line}: {why}");
}

#[test]
fn joined_files_and_other_lines_ends_are_read() {
    let (one, other) = (written(&[device_row(10)]), written(&[device_row(20)]));
    let joined = String::from_utf8([one, other].concat()).expect("text").replace('\n', "\r\n");
    let recording = read(("\u{feff}".to_owned() + &joined).as_bytes()).expect("a recording");
    assert_eq!((recording.records.len(), recording.bad_lines, recording.torn), (2, 0, false));
}

#[test]
fn what_is_no_recording_is_refused_with_the_reason() {
    for (text, named) in [
        (String::new(), "no column"),
        ("pressure_kpa,bend_deg\n30,40\n".into(), "\"schema\""),
        (header(), "not one whole row"),
        (header() + "1,2,3\n", "line 2: 3 fields, where the header has 46"),
        (header() + &row(&device_row(10)).replacen('2', "3", 1), "schema 3 is newer than 2"),
        (header() + &row(&device_row(10)) + "x\ny\n", "of its lines 2 are no rows"),
    ] {
        let error = read(text.as_bytes()).expect_err(&text).to_string();
        assert!(error.contains(named), "{error}");
    }
}

#[test]
fn the_first_schema_is_read_too() {
    let text = "schema,time_ms,mode,repeat,step,holding,pump_on,dump_open,valve_proximal_open,valve_middle_open,\
        valve_distal_open,setpoint_proximal_kpa,setpoint_middle_kpa,setpoint_distal_kpa,estimate_proximal_kpa,\
        estimate_middle_kpa,estimate_distal_kpa,chamber_proximal_kpa,chamber_middle_kpa,chamber_distal_kpa,manifold_kpa,\
        sensor_kpa,bend_proximal_deg,bend_middle_deg,bend_distal_deg,bend_finger_deg,bend_sensor_deg\n\
        1,0,running,1,2,1,1,0,1,0,0,60.0000,30.0000,0.0000,1.0000,2.0000,3.0000,4.0000,5.0000,6.0000,7.0000,8.0000,\
        9.0000,10.0000,11.0000,30.0000,31.0000\n\
        1,1,faulted:over-pressure,0,0,0,0,1,1,1,1,0,0,0,0,0,0,0,0,0,0,,0,0,0,0,\n";
    let recording = read(text.as_bytes()).expect("a recording");
    assert_eq!((recording.schema, recording.bad_lines), (1, 0), "{:?}", recording.first_bad);
    let [first, second] = recording.records.as_slice() else { panic!("{recording:?}") };
    assert_eq!((first.source, first.mode, first.step, first.repeat), (Source::Simulated, LinkMode::Running, 2, 1));
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(close(first.chambers_kpa[2], 6.0) && close(first.bend_sensor_deg, 31.0) && close(first.finger_deg(), 30.0));
    assert!(first.actuation.pump && first.force_n.is_nan());
    assert_eq!((second.priority, second.faults.bits()), (3, 1));
    assert!(second.sensor_kpa.is_nan() && second.bend_sensor_deg.is_nan());
}

#[test]
fn an_event_cannot_break_its_line() {
    let mut record = device_row(10);
    record.event = "he said \"vent\", now\nand \r\n again".into();
    let recording = read(&written(&[record])).expect("a recording");
    assert_eq!(recording.records[0].event, "he said 'vent'; now and    again");
}

#[test]
fn a_recording_goes_on_after_a_cut() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("record.csv");
    let record = |writer: &mut RecordWriter<File>, time_ms| writer.write(&device_row(time_ms)).expect("written");
    record(&mut RecordWriter::append(&path, 1).expect("new"), 10);
    let whole = std::fs::read(&path).expect("there");
    for cut in [whole.len(), whole.len() - 1, whole.len() - 60] {
        std::fs::write(&path, &whole[..cut]).expect("cut");
        record(&mut RecordWriter::append(&path, 1).expect("goes on"), 20);
        let recording = read(&std::fs::read(&path).expect("there")).expect("a recording");
        assert_eq!(recording.records.len(), if cut == whole.len() { 2 } else { 1 }, "cut at {cut}");
        assert_eq!((recording.torn, recording.bad_lines), (false, 0), "cut at {cut}");
    }
    std::fs::write(&path, "schema,other\n").expect("written");
    let error = RecordWriter::append(&path, 1).expect_err("another file").to_string();
    assert!(error.contains("record.csv") && error.contains("schema 2"), "{error}");
    assert_eq!(std::fs::read_to_string(&path).expect("there"), "schema,other\n");
}

/// A disk that takes a few bytes, and fails every third time.
#[derive(Default)]
struct Shaky {
    bytes: Vec<u8>,
    calls: u32,
}

impl Write for &mut Shaky {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.calls += 1;
        if self.calls.is_multiple_of(3) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let taken = bytes.len().min(50);
        self.bytes.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_failing_disk_doubles_no_byte() {
    let mut disk = Shaky::default();
    let mut writer = RecordWriter::go_on(&mut disk, 1);
    let records: Vec<Record> = (1..=9).map(|index| device_row(index * 10)).collect();
    let failed = records.iter().filter(|record| writer.write(record).is_err()).count();
    assert!(failed > 0);
    while writer.flush().is_err() {}
    drop(writer);
    assert_eq!(String::from_utf8(disk.bytes).expect("text"), texts(&records).concat());
}

#[test]
fn rows_wait_for_their_flush_and_no_longer() {
    let mut bytes = Vec::new();
    let mut writer = RecordWriter::new(&mut bytes, 3).expect("memory");
    for time_ms in 1..=4 {
        writer.write(&device_row(time_ms)).expect("memory");
    }
    assert_eq!(writer.held, 1);
    writer.flush().expect("memory");
    assert_eq!(writer.held, 0);
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_fall(bytes in proptest::collection::vec(any::<u8>(), 0..400), flips in 0_usize..300) {
        let _ = read(&bytes);
        let mut damaged = written(&[device_row(10), device_row(20)]);
        for (index, byte) in bytes.iter().enumerate() {
            let place = (index * 37 + flips) % damaged.len();
            damaged[place] ^= byte;
        }
        let _ = read(&damaged);
    }
}
