//! `klieg studio` as a server: who may speak to it, what it bears, and how it ends.

use klieg_support::common::Folder;
use klieg_support::studio::{Message, Said, Server, look, with};
use serde_json::json;
use std::process::Command;
use std::time::{Duration, Instant};

const BALL: &[&str] = &["ball.gltf"];

#[test]
fn only_its_own_page_is_answered() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (host, token) = (server.host.clone(), server.token.clone());
    let port = host.split(':').nth(1).unwrap().to_owned();
    let status = |path: &str, host: &str, more: &str| {
        let head =
            format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}Connection: close\r\n\r\n");
        server.raw(&head, b"").0
    };
    let own = format!("x-klieg-token: {token}\r\n");
    for path in ["/", "/studio.js", "/studio.css", "/icon.svg"] {
        assert_eq!(status(path, &host, ""), 200, "{path}");
    }
    assert_eq!(status("/", &format!("localhost:{port}"), ""), 200);
    assert_eq!(status("/", &host, &format!("Origin: http://{host}\r\n")), 200);
    // Another name that leads here, another page, and another scheme.
    for (other, more) in [
        (format!("evil.example:{port}"), String::new()),
        (format!("127.0.0.1:{}", u16::MAX), String::new()),
        (host.clone(), "Origin: http://evil.example\r\n".into()),
        (host.clone(), format!("Origin: https://{host}\r\n")),
        (host.clone(), "Origin: null\r\n".into()),
    ] {
        for path in ["/", "/socket", "/nowhere"] {
            assert_eq!(status(path, &other, &format!("{own}{more}")), 403, "{other} {more}");
        }
    }
    let head = "GET / HTTP/1.1\r\nConnection: close\r\n\r\n";
    assert!(server.raw(head, b"").0 >= 400, "without a host");
    // Without the token, and with another one.
    let wrong = format!("x-klieg-token: {}\r\n", "0".repeat(32));
    for path in ["/scene?name=a.glb", "/save/glb", "/socket", "/nowhere"] {
        assert_eq!((status(path, &host, ""), status(path, &host, &wrong)), (403, 403), "{path}");
        assert_ne!(status(path, &host, &own), 403, "{path}");
    }
    for token in ["", "0", &"0".repeat(32), &token[1..]] {
        assert_eq!(server.connect(token).err(), Some(403), "{token}");
    }
    assert!(server.connect(&token).is_ok());
    let (_, head, _) = server.request("GET", "/", b"");
    for line in
        ["content-security-policy: default-src 'none'; script-src 'self'", "nosniff", "no-store"]
    {
        assert!(head.contains(line), "{head}");
    }
}

#[test]
fn what_is_too_large_or_no_scene_is_refused() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (host, token) = (&server.host, &server.token);
    let head = format!(
        "POST /scene?name=a.glb HTTP/1.1\r\nHost: {host}\r\nx-klieg-token: {token}\r\n\
         Content-Length: {}\r\nConnection: close\r\n\r\n",
        4_u64 << 30
    );
    let begin = Instant::now();
    let (status, _, body) = server.raw(&head, b"glTF");
    assert!(status == 413 && String::from_utf8_lossy(&body).contains("512 MiB"), "{status}");
    assert!(begin.elapsed() < Duration::from_secs(10), "it waited for what was announced");
    for (name, bytes, words) in [
        ("a.glb", &b"no scene"[..], "a.glb"),
        ("a.gltf", &b"{}"[..], "a.gltf"),
        ("a.exe", &b""[..], "no scene that klieg reads"),
        ("..%2f..%2fetc%2fpasswd", &b""[..], "no scene that klieg reads"),
    ] {
        let (status, answer) = server.post(name, bytes);
        let error = answer["error"].as_str().unwrap();
        assert!(status == 400 && error.contains(words), "{status} {error}");
        assert!(!error.contains("klieg-studio-"), "{error}");
    }
    // A scene that names a file beside itself finds none.
    let mut scene = klieg_support::common::ball();
    scene["buffers"][0]["uri"] = "../../../../etc/passwd".into();
    assert_eq!(server.post("a.gltf", scene.to_string().as_bytes()).0, 400);
}

#[test]
fn malformed_requests_are_faults_and_nothing_more() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let shown = with(&look(&opened), json!({ "at_rest": false }));
    for text in
        ["", "{", "[]", "null", "{\"type\":\"draw\"}", "{\"type\":\"sing\",\"id\":1}", "\u{0}"]
    {
        page.socket.send(Message::text(text)).unwrap();
        let Said::Answer(fault) = page.read() else { panic!("a picture") };
        assert_eq!(fault["type"], "fault", "{text}");
    }
    page.socket.send(Message::binary(vec![1, 2, 3])).unwrap();
    assert!(matches!(page.read(), Said::Answer(fault) if fault["type"] == "fault"));
    let lights = |field: &str, value: serde_json::Value| {
        let mut lights = shown["lights"].clone();
        lights[0][field] = value;
        json!({ "lights": lights })
    };
    for (spoiled, words) in [
        (json!({ "lights": [] }), "0 lights"),
        (json!({ "lights": vec![shown["lights"][0].clone(); 17] }), "17 lights"),
        (lights("direction", json!([0, 0, 0])), "direction"),
        (lights("distance", json!(-1)), "distance"),
        (lights("diffuse", json!(1e39)), "diffuse"),
        (json!({ "size": [0, 10] }), "no pixels"),
        (json!({ "size": [40_000, 40_000] }), "too large"),
        (json!({ "weights": { "edge": -1.0 } }), "weight edge"),
        (json!({ "weights": { "bornt": 1.0 } }), "bornt"),
        (json!({ "weights": { "target": 1.0 } }), "target"),
        (json!({ "targets": { "mean": 2.0, "stops": 0.0, "spread": 0.2 } }), "mean_target"),
        (json!({ "camera": with(&shown["camera"], json!({ "named": "nobody" })) }), "nobody"),
        (json!({ "camera": with(&shown["camera"], json!({ "yfov": 181.0 })) }), "yfov"),
    ] {
        let id = page.send("draw", with(&shown, spoiled.clone()));
        let fault = page.until("fault", id);
        assert!(fault["message"].as_str().unwrap().contains(words), "{spoiled}: {fault}");
    }
    let faults = [
        ("map", json!({ "light": 9, "columns": 9, "rows": 9 }), "no light 9"),
        ("map", json!({ "light": 0, "columns": 4_000_000, "rows": 9 }), "columns"),
        ("place", json!({ "light": 9, "what": "rim", "pixel": [1, 1] }), "no light 9"),
        ("search", json!({ "action": "start", "optimizer": "luck" }), "luck"),
        ("alternatives", json!({ "count": 1_000_000 }), "count"),
        ("preset", json!({ "name": "disco" }), "disco"),
    ];
    for (kind, spoiled, words) in faults {
        let id = page.send(kind, with(&shown, spoiled));
        let fault = page.until("fault", id);
        assert!(fault["message"].as_str().unwrap().contains(words), "{kind}: {fault}");
    }
    let id = page.send("draw", shown.clone());
    page.drawn(id, 1);
    // More than a request may have ends this page, and no other.
    let _ = page.socket.send(Message::text("x".repeat(2 << 20)));
    while page.socket.read().is_ok() {}
    let (mut page, _) = server.page();
    let id = page.send("draw", shown);
    page.drawn(id, 1);
}

#[test]
fn memory_stays_where_it_is() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let shown = with(&look(&opened), json!({ "at_rest": false }));
    let mut drag = |steps: u32| {
        for step in 0..steps {
            let mut moved = shown.clone();
            moved["lights"][0]["direction"] = json!([f64::from(step % 90) / 90.0, 0.5, 0.5]);
            if step % 40 == 0 {
                moved["camera"]["azimuth"] = f64::from(step % 7).into();
            }
            page.ask("draw", moved, "judged");
        }
    };
    drag(300);
    let before = server.memory();
    drag(1000);
    let after = server.memory();
    assert!(after < before + (24 << 10), "{before} KiB, then {after} KiB");
}

#[test]
fn pages_come_and_go() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let tasks = || {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", server.child.id())).unwrap();
        tasks.count()
    };
    let (_page, opened) = server.page();
    let before = tasks();
    for _ in 0..20 {
        let (mut page, _) = server.page();
        page.send("search", with(&look(&opened), json!({ "action": "start" })));
        page.send("draw", with(&look(&opened), json!({ "at_rest": true })));
    }
    let begin = Instant::now();
    while tasks() > before + 2 {
        assert!(begin.elapsed() < Duration::from_secs(60), "{} threads, {before} before", tasks());
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn ctrl_c_ends_it_at_once_and_well() {
    let place = Folder::new();
    let mut server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    page.send("search", with(&look(&opened), json!({ "action": "start" })));
    let scene = std::fs::read(place.path("ball.gltf")).unwrap();
    let posted = server.post("a.gltf", &scene).1;
    page.ask("open", json!({ "scene": posted["id"] }), "opened");
    assert_eq!(place.list("tmp").len(), 1);
    let begin = Instant::now();
    let pid = server.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(server.child.wait().unwrap().code(), Some(0));
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    assert_eq!(place.list("tmp"), [""; 0], "what was posted is left behind");
}

#[test]
fn bad_input_is_named() {
    let place = Folder::new();
    std::fs::write(place.path("text.glb"), "not a scene").unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    for (arguments, code, words) in [
        (&["nothing.glb"][..], 2, "nothing.glb"),
        (&["text.glb"], 2, "text.glb"),
        (&["ball.gltf", "--camera", "nobody"], 2, "nobody"),
        (&["--port", "70000"], 2, "70000"),
        (&["ball.gltf", "--port", &port], 1, &port),
    ] {
        let arguments = [&["studio", "--no-open"][..], arguments].concat();
        let output = place.klieg(&arguments).timeout(Duration::from_secs(60)).assert().code(code);
        let error = String::from_utf8(output.get_output().stderr.clone()).unwrap();
        assert!(error.contains(words) && output.get_output().stdout.is_empty(), "{error}");
    }
}
