//! The server by raw sockets: who is let in, who is not, and what it survives.

use std::path::Path;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::time::{Duration, timeout};

use super::*;
use crate::live::{ROWS_MOST, Source, feed};
use crate::viewed::Viewed;
use samara_mission::mission_path;

/// A server of a built-in mission that waits for a tenth of a second, its port and its token.
async fn served(mission: &str) -> (u16, String) {
    let path = mission_path(Path::new(mission)).unwrap();
    let viewed = Viewed { path, typed: mission.to_owned(), set: Vec::new() };
    let server = Server::listen(Shown::Mission(viewed), 0).unwrap().patient_for(Duration::from_millis(100));
    let (port, token) = (server.address.port(), server.token.to_string());
    assert_eq!(server.address(), format!("http://127.0.0.1:{port}/#{token}"));
    tokio::spawn(server.serve());
    (port, token)
}

/// A server of a flight that waits for a tenth of a second, with the flight's own end.
async fn flying() -> ((u16, String), Source, tokio::task::JoinHandle<()>) {
    let (source, feed) = feed();
    let server = Server::listen(Shown::Flight(feed), 0).unwrap().patient_for(Duration::from_millis(100));
    let place = (server.address.port(), server.token.to_string());
    (place, source, tokio::spawn(server.serve_to_the_end()))
}

/// All that comes back for these bytes until the server closes.
async fn sent(port: u16, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
    // The server may have closed already.
    let _ = stream.write_all(bytes).await;
    let mut answer = Vec::new();
    let _ = timeout(Duration::from_secs(60), stream.read_to_end(&mut answer)).await.unwrap();
    String::from_utf8(answer).unwrap()
}

/// A request with the headers that a browser sends, and these, the body last.
fn request(port: u16, line: &str, headers: &[&str], body: &str) -> String {
    let own = ["Host: 127.0.0.1", "Connection: close"];
    let own = [format!("{}:{port}", own[0]), own[1].to_owned(), format!("Content-Length: {}", body.len())];
    let all = own.into_iter().chain(headers.iter().map(|header| (*header).to_owned()));
    let all: Vec<String> = all.collect();
    format!("{line} HTTP/1.1\r\n{}\r\n\r\n{body}", all.join("\r\n"))
}

fn status(answer: &str) -> u16 {
    answer.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap_or(0)
}

fn body(answer: &str) -> &str {
    answer.split_once("\r\n\r\n").map_or("", |(_, body)| body)
}

const JSON: &str = "Content-Type: application/json";

/// A browser that has the token.
struct Browser {
    port: u16,
    cookie: String,
}

impl Browser {
    async fn of((port, token): &(u16, String)) -> Self {
        let enter = request(*port, "POST /enter", &[JSON], &format!("{{\"token\":\"{token}\"}}"));
        let answer = sent(*port, enter.as_bytes()).await;
        assert_eq!(status(&answer), 204, "{answer}");
        let cookie = answer.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
        assert_eq!(cookie, format!("samara_{port}={token}; HttpOnly; SameSite=Strict; Path=/"));
        Self { port: *port, cookie: format!("Cookie: a=b; {}", cookie.split(';').next().unwrap()) }
    }

    async fn get(&self, path: &str) -> String {
        sent(self.port, request(self.port, &format!("GET {path}"), &[&self.cookie], "").as_bytes()).await
    }

    async fn post(&self, path: &str, body: &str) -> String {
        let line = format!("POST {path}");
        sent(self.port, request(self.port, &line, &[&self.cookie, JSON], body).as_bytes()).await
    }
}

/// Each rule of the door, one request each: what is not let in learns nothing.
#[tokio::test]
async fn only_the_browser_with_the_token_is_served() {
    let server = served("x500_drop").await;
    let (port, token) = (server.0, server.1.as_str());
    let browser = Browser::of(&server).await;
    let (own, cookie) = (format!("Origin: http://127.0.0.1:{port}"), browser.cookie.as_str());
    let wrong = format!("Cookie: samara_{port}={}", "0".repeat(32));
    let short = format!("Cookie: samara_{port}={}", &token[..31]);
    let query = format!("GET /mission?token={token}");
    let elsewhere = format!("Origin: http://127.0.0.1:{}", port ^ 1);
    let long = "x".repeat((64 << 10) + 1);
    let fly = "{\"number\":1,\"changes\":{\"limits.pitch_deg\":\"x\"}}";
    for (line, headers, body, expected) in [
        ("GET /", &[] as &[&str], "", 200),
        ("GET /view.js", &[], "", 200),
        ("GET /view.css", &[&own], "", 200),
        // A page that leads here from elsewhere gets the page, and nothing with it.
        ("GET /", &["Sec-Fetch-Site: cross-site"], "", 200),
        ("GET /view.js", &["Sec-Fetch-Site: cross-site"], "", 403),
        ("GET /mission", &[cookie, &own, "Sec-Fetch-Site: same-origin"], "", 200),
        ("GET /mission", &[], "", 403),
        ("GET /mission", &[&wrong], "", 403),
        ("GET /mission", &[&short], "", 403),
        (&query, &[], "", 403),
        ("GET /mission", &[cookie, "Origin: http://example.org"], "", 403),
        ("GET /mission", &[cookie, "Origin: null"], "", 403),
        ("GET /mission", &[cookie, &elsewhere], "", 403),
        ("GET /mission", &[cookie, &own, &own], "", 403),
        ("GET /mission", &[cookie, "Sec-Fetch-Site: same-site"], "", 403),
        ("GET http://example.org/mission", &[cookie], "", 403),
        ("POST /fly", &[cookie, JSON, &own], fly, 422),
        ("POST /fly", &[JSON], fly, 403),
        ("POST /fly", &[cookie, JSON, "Origin: null"], fly, 403),
        ("POST /fly", &[cookie, JSON, "Origin: https://example.org"], fly, 403),
        ("POST /fly", &[cookie, "Content-Type: text/plain"], fly, 415),
        ("POST /fly", &[cookie], fly, 415),
        ("POST /fly", &[cookie, JSON], &long, 413),
        ("POST /fly", &[cookie, JSON], "{", 400),
        ("POST /fly", &[cookie, JSON], "{\"number\":-1}", 400),
        ("POST /fly", &[cookie, JSON], "{\"number\":1,\"changes\":{\"a\":1}}", 422),
        ("POST /enter", &[JSON], "{\"token\":\"\"}", 403),
        ("POST /enter", &[JSON], "{\"token\":1}", 403),
        ("POST /enter", &[JSON, "Origin: http://example.org"], &format!("{{\"token\":\"{token}\"}}"), 403),
        ("POST /none", &[cookie, JSON], "{}", 404),
        ("GET /none", &[cookie], "", 404),
        ("GET /run", &[cookie], "", 404),
        ("GET /../Cargo.toml", &[cookie], "", 404),
        ("GET /%2e%2e/%2e%2e/etc/passwd", &[cookie], "", 404),
        ("GET //etc/passwd", &[cookie], "", 404),
        ("HEAD /", &[], "", 405),
        ("PUT /mission", &[cookie, JSON], "{}", 405),
        ("OPTIONS /fly", &[&own], "", 405),
    ] {
        let answer = sent(port, request(port, line, headers, body).as_bytes()).await;
        assert_eq!(status(&answer), expected, "{line} {headers:?}\n{answer}");
        for (name, value) in guard::HEADERS {
            assert!(answer.contains(&format!("{name}: {value}\r\n")), "{line}: {name}\n{answer}");
        }
        assert!(!answer.contains(token), "{line}\n{answer}");
        assert!(!answer.to_lowercase().contains("access-control"), "{line}\n{answer}");
    }
    for host in ["example.org", "127.0.0.1", "127.0.0.1:1", "localhost.example.org", ""] {
        let text = format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        assert_eq!(status(&sent(port, text.as_bytes()).await), 403, "{host}");
    }
    let twice = format!("GET / HTTP/1.1\r\nHost: localhost:{port}\r\nHost: a\r\nConnection: close\r\n\r\n");
    assert_eq!(status(&sent(port, twice.as_bytes()).await), 403);
    let named = format!("GET / HTTP/1.1\r\nHost: LocalHost:{port}\r\nConnection: close\r\n\r\n");
    assert_eq!(status(&sent(port, named.as_bytes()).await), 200);
    let none = "GET / HTTP/1.0\r\n\r\n";
    assert_eq!(status(&sent(port, none.as_bytes()).await), 403);
}

/// Garbage, half a head, half a body and forty who say nothing: each is closed in its time, and the browser
/// is served.
#[tokio::test]
async fn it_survives_who_means_it_ill() {
    let server = served("x500_drop").await;
    let port = server.0;
    let browser = Browser::of(&server).await;
    for garbage in [&b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"[..], b"\0\r\n\r\n", &[b'a'; 200_000]] {
        let answer = sent(port, garbage).await;
        assert!(answer.is_empty() || (400..500).contains(&status(&answer)), "{answer}");
    }
    // Half a head, and a head whose body never comes.
    assert!(!sent(port, b"GET / HTTP/1.1\r\nHost: ").await.contains("200"));
    let promised = format!(
        "POST /fly HTTP/1.1\r\nHost: localhost:{port}\r\n{JSON}\r\n{}\r\nContent-Length: 10\r\n\r\n{{",
        browser.cookie
    );
    let mut held = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
    held.write_all(promised.as_bytes()).await.unwrap();
    let mut silent = Vec::new();
    for _ in 0..40 {
        silent.push(TcpStream::connect(("127.0.0.1", port)).await.unwrap());
    }
    assert_eq!(status(&browser.get("/mission").await), 200);
    let mut answer = vec![0; 12];
    held.read_exact(&mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 408");
    for mut stream in silent {
        // Closed, as they said nothing.
        assert!(stream.read(&mut [0; 512]).await.is_ok());
    }
    // Two requests at once on one connection: two answers.
    let one = format!("GET /view.css HTTP/1.1\r\nHost: localhost:{port}\r\n");
    let answer = sent(port, format!("{one}\r\n{one}Connection: close\r\n\r\n").as_bytes()).await;
    assert_eq!(answer.matches("HTTP/1.1 200 OK").count(), 2, "{answer}");
}

/// A drop that is asked for twice is the same; what is older than the newest number is not flown; a campaign
/// gives its lines as they are there, and ends when something newer is asked.
#[tokio::test]
async fn the_newest_number_wins() {
    let server = served("../../tests/calm_x500.json").await;
    let browser = Browser::of(&server).await;
    let flown = browser.post("/fly", "{\"number\":5,\"changes\":{\"mass_kg\":\"2.1\"}}").await;
    let object: serde_json::Value = serde_json::from_str(body(&flown)).unwrap();
    assert_eq!((status(&flown), &object["number"], &object["passed"]), (200, &5.into(), &true.into()));
    assert_eq!(object["command"], "samara drop ../../tests/calm_x500.json --set mass_kg=2.1");
    assert!(object["drop"]["flight"]["count"].as_u64().is_some_and(|rows| rows > 1000));
    assert!(object["words"]["verdict"].as_str().is_some_and(|html| html.starts_with("Safe: ")));
    assert_eq!(object["loops"].as_array().map(Vec::len), Some(9));
    let older = browser.post("/fly", "{\"number\":4,\"changes\":{}}").await;
    assert_eq!((status(&older), body(&older)), (409, "{\"number\":4,\"overtaken\":true}"));
    let refused = browser.post("/fly", "{\"number\":6,\"changes\":{\"limits.pitch_deg\":\"soon\"}}").await;
    let object: serde_json::Value = serde_json::from_str(body(&refused)).unwrap();
    assert_eq!((status(&refused), &object["key"]), (422, &"limits.pitch_deg".into()));
    assert!(object["error"].as_str().is_some_and(|text| text.contains("expected a number greater than 0")));

    let (port, cookie) = (browser.port, browser.cookie.as_str());
    let asked = request(port, "POST /campaign", &[cookie, JSON], "{\"number\":7,\"changes\":{}}");
    let mut stream = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
    stream.write_all(asked.as_bytes()).await.unwrap();
    let mut lines = String::new();
    while !lines.contains("\"from\":0") {
        let mut some = [0; 4096];
        let count = stream.read(&mut some).await.unwrap();
        assert!(count > 0, "{lines}");
        lines += std::str::from_utf8(&some[..count]).unwrap();
    }
    assert_eq!(status(&browser.post("/fly", "{\"number\":8,\"changes\":{\"x\":\"1\"}}").await), 422);
    stream.read_to_string(&mut lines).await.unwrap();
    assert!(lines.contains("{\"overtaken\":true}\n") && !lines.contains("done"), "{lines}");
}

/// The page of a flight has the door of the mission's, and nothing else behind it.
#[tokio::test]
async fn a_flight_is_shown_to_the_browser_with_the_token_alone() {
    let (server, mut source, _) = flying().await;
    source.flight(serde_json::json!({ "mission": "secret" }));
    let (port, browser) = (server.0, Browser::of(&server).await);
    let (own, cookie) = (format!("Origin: http://127.0.0.1:{port}"), browser.cookie.as_str());
    let wrong = format!("Cookie: samara_{port}={}", "0".repeat(32));
    let elsewhere = format!("Origin: http://127.0.0.1:{}", port ^ 1);
    let query = format!("GET /flight?token={}", server.1);
    for (line, headers, expected) in [
        ("GET /", &[] as &[&str], 200),
        ("GET /live.js", &[&own], 200),
        ("GET /live.css", &[], 200),
        ("GET /live.js", &["Sec-Fetch-Site: cross-site"], 403),
        ("GET /flight", &[], 403),
        ("GET /flight", &[&wrong], 403),
        (&query, &[], 403),
        ("GET /flight", &[cookie, "Origin: http://example.org"], 403),
        ("GET /flight", &[cookie, "Origin: null"], 403),
        ("GET /flight", &[cookie, &elsewhere], 403),
        ("GET /flight", &[cookie, "Sec-Fetch-Site: same-site"], 403),
        ("GET /flight", &[cookie, "Sec-Fetch-Site: cross-site"], 403),
        ("GET http://example.org/flight", &[cookie], 403),
        ("POST /flight", &[cookie, "Content-Type: text/plain"], 415),
        ("POST /flight", &[cookie, JSON], 404),
        ("POST /fly", &[cookie, JSON], 404),
        ("GET /mission", &[cookie], 404),
        ("GET /view.js", &[cookie], 404),
        ("HEAD /flight", &[cookie], 405),
    ] {
        let body = if line.starts_with("POST") { "{}" } else { "" };
        let answer = sent(port, request(port, line, headers, body).as_bytes()).await;
        assert_eq!(status(&answer), expected, "{line} {headers:?}\n{answer}");
        for (name, value) in guard::HEADERS {
            assert!(answer.contains(&format!("{name}: {value}\r\n")), "{line}: {name}\n{answer}");
        }
        assert!(!answer.contains("secret") && !answer.contains(&server.1), "{line}\n{answer}");
    }
    for garbage in [&b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"[..], b"\0\r\n\r\n", &[b'a'; 200_000]] {
        let answer = sent(port, garbage).await;
        assert!(answer.is_empty() || (400..500).contains(&status(&answer)), "{answer}");
    }
    source.end(serde_json::json!({}));
    assert!(browser.get("/flight").await.contains("\"flight\":{\"mission\":\"secret\"}"));
}

/// Four who ask and never read hold nobody up: what flies, who reads, and the server's end.
#[tokio::test]
async fn four_who_never_read_hold_nobody_up() {
    let (server, mut source, served) = flying().await;
    let (port, browser) = (server.0, Browser::of(&server).await);
    source.flight(serde_json::json!({ "mission": "x" }));
    let ask = request(port, "GET /flight", &[&browser.cookie], "");
    let mut silent = Vec::new();
    for _ in 0..4 {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
        stream.write_all(ask.as_bytes()).await.unwrap();
        silent.push(stream);
    }
    // More than the system keeps on the way.
    for i in 0..ROWS_MOST {
        source.row(&[std::f64::consts::PI * i as f64; 40]);
        if i % 1000 == 0 {
            source.event(serde_json::json!(i));
            tokio::task::yield_now().await;
        }
    }
    source.end(serde_json::json!({ "text": "over" }));
    let answer = browser.get("/flight").await;
    let lines = answer.lines().filter(|line| line.starts_with("{\"rows\":"));
    assert_eq!(lines.map(|line| line.matches("],[").count() + 1).sum::<usize>(), ROWS_MOST);
    assert_eq!(answer.matches("\"event\":").count(), ROWS_MOST / 1000);
    assert!(answer.contains("{\"end\":{\"text\":\"over\"}}\n"), "{}", &answer[answer.len() - 200..]);
    timeout(Duration::from_secs(10), served).await.unwrap().unwrap();
}

/// A run of one page and one campaign.
#[derive(Debug)]
struct OneRun(crate::run::RunTold);

impl crate::run::Run for OneRun {
    fn told(&self) -> &crate::run::RunTold {
        &self.0
    }

    fn page(&self, name: &str) -> Option<String> {
        (name == "drop.html").then(|| "<p>the drop".to_owned())
    }

    fn trial(&self, campaign: &str, trial: u64) -> Result<String, String> {
        if trial < 3 { Ok(format!("<p>{campaign} {trial}")) } else { Err("there are three".to_owned()) }
    }
}

/// Pages and trials are found by their places alone, and stand apart from the server's own page: by a policy
/// of their own, in a sandbox. A path to anywhere else leads nowhere.
#[tokio::test]
async fn a_run_shows_its_pages_and_trials_and_nothing_else() {
    use crate::run::{CampaignTold, RunTold, TrialTold};
    let worst = vec![TrialTold { trial: 2, j_tpf: Some(0.9), steady_after_s: None }];
    let campaign = CampaignTold { name: "drops".to_owned(), worst, ..CampaignTold::default() };
    let pages = vec!["drop.html".to_owned(), "gone.html".to_owned()];
    let told = RunTold { pages, campaigns: vec![campaign], ..RunTold::default() };
    let server = Server::listen(Shown::Run(Arc::new(OneRun(told))), 0).unwrap();
    let place = (server.address.port(), server.token.to_string());
    tokio::spawn(server.serve());
    for path in ["/run", "/page/0", "/trial/0/2"] {
        let answer = sent(place.0, request(place.0, &format!("GET {path}"), &[], "").as_bytes()).await;
        assert_eq!((status(&answer), body(&answer)), (403, "Forbidden"), "{path}");
    }
    let browser = Browser::of(&place).await;
    for path in ["/", "/folder.js", "/folder.css", "/run"] {
        assert_eq!(status(&browser.get(path).await), 200, "{path}");
    }
    let told: serde_json::Value = serde_json::from_str(body(&browser.get("/run").await)).unwrap();
    assert_eq!(
        told["campaigns"][0]["worst"][0],
        serde_json::json!({ "trial": 2, "j_tpf": 0.9, "steady_after_s": null })
    );
    for (path, expected, text) in [
        ("/page/0", 200, "<p>the drop"),
        ("/page/1", 404, "Not Found"),
        ("/page/2", 404, "Not Found"),
        ("/page/-1", 404, "Not Found"),
        ("/page/..%2f..%2fetc%2fpasswd", 404, "Not Found"),
        ("/page/drop.html", 404, "Not Found"),
        ("/page/0/", 404, "Not Found"),
        ("/trial/0/2", 200, "<p>drops 2"),
        ("/trial/0/3", 422, "there are three"),
        ("/trial/1/2", 404, "Not Found"),
        ("/trial/0/18446744073709551616", 404, "Not Found"),
        ("/trial/0", 404, "Not Found"),
        ("/mission", 404, "Not Found"),
        ("/flight", 404, "Not Found"),
    ] {
        let answer = browser.get(path).await;
        assert_eq!((status(&answer), body(&answer)), (expected, text), "{path}");
        assert_eq!(answer.contains("sandbox allow-scripts"), expected == 200, "{path}");
        assert!(
            answer.contains("frame-ancestors 'none'") && answer.contains("cache-control: no-store"),
            "{path}"
        );
    }
    assert_eq!(status(&browser.post("/run", "{}").await), 404);
}
